#include "engine_client/cli/io/csv_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

namespace sweepstake::cli {
namespace {

TEST(CsvFile, AppearsOnlyWhenItIsCommitted) {
  const std::filesystem::path path = testing::TempDir() + "sweepstake_csv_file_test.csv";
  std::filesystem::remove(path);
  {
    const auto dropped = std::move(*CsvFile::Create(path, {"a", "b"}));
    dropped->Row({"1", "2"});
  }
  EXPECT_FALSE(std::filesystem::exists(path));
  const auto kept = std::move(*CsvFile::Create(path, {"a", "b"}));
  kept->Row({"1", "x,y"});
  kept->Row({"a\"b", "a\nb"});
  EXPECT_FALSE(std::filesystem::exists(path));
  EXPECT_TRUE(kept->Commit().ok());
  std::stringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  EXPECT_EQ(text.str(), "a,b\r\n1,\"x,y\"\r\n\"a\"\"b\",\"a\nb\"\r\n") << "quoted as in RFC 4180";
  std::filesystem::remove(path);
}

TEST(CsvFile, NamesTheFileThatCannotBeWritten) {
  const auto csv = CsvFile::Create("/nonexistent/x.csv", {"a"});
  ASSERT_FALSE(csv.ok());
  EXPECT_NE(csv.status().message().find("/nonexistent/x.csv"), std::string::npos);
}

}  // namespace
}  // namespace sweepstake::cli
