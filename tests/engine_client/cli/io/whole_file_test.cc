#include "engine_client/cli/io/whole_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <string>

#include "tests/support/temporary_directory.h"

namespace sweepstake::cli {
namespace {

using std::filesystem::path;

std::string Content(const path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

size_t FileCount(const path& folder) {
  return static_cast<size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

TEST(WholeFile, ReplacesTheOldFileOnlyWhenItIsCommitted) {
  const test_support::TemporaryDirectory folder;
  const path place = folder.path() / "out.html";
  std::ofstream(place) << "old";
  const auto file = std::move(*WholeFile::Create(place));
  file->Write("new ");
  file->Write("content");
  EXPECT_EQ(Content(place), "old");
  EXPECT_TRUE(file->Commit().ok());
  EXPECT_EQ(Content(place), "new content");
  EXPECT_EQ(FileCount(folder.path()), 1U);
}

TEST(WholeFile, LeavesNoFileWithoutACommit) {
  const test_support::TemporaryDirectory folder;
  (*WholeFile::Create(folder.path() / "out.html"))->Write("half");
  EXPECT_EQ(FileCount(folder.path()), 0U);
}

TEST(WholeFile, RejectsAFileThatCannotBeWrittenAtOnce) {
  const test_support::TemporaryDirectory folder;
  for (const path& place : {folder.path(), path("/nonexistent/out.html"), path("/dev/null"),
                            path(""), folder.path() / "new" / ""}) {
    const auto file = WholeFile::Create(place);
    ASSERT_FALSE(file.ok()) << place;
    EXPECT_EQ(file.status().code(), StatusCode::kInvalidArgument);
    EXPECT_NE(file.status().message().find(place.string()), std::string::npos);
  }
  EXPECT_EQ(FileCount(folder.path()), 0U);
}

TEST(WriteRow, QuotesCellsAsInRfc4180) {
  const test_support::TemporaryDirectory folder;
  const path place = folder.path() / "rows.csv";
  const auto file = std::move(*WholeFile::Create(place));
  file->WriteRow({"a", "b"});
  file->WriteRow({"1", "x,y"});
  file->WriteRow({"a\"b", "a\nb"});
  EXPECT_TRUE(file->Commit().ok());
  EXPECT_EQ(Content(place), "a,b\r\n1,\"x,y\"\r\n\"a\"\"b\",\"a\nb\"\r\n");
}

}  // namespace
}  // namespace sweepstake::cli
