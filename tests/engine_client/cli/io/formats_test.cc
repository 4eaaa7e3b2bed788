#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "engine_client/cli/command.h"
#include "engine_client/cli/game/run_report.h"
#include "engine_client/cli/io/csv_file.h"
#include "engine_client/cli/io/duration.h"
#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/terminal.h"

namespace sweepstake::cli {
namespace {

TEST(ParseDuration, TakesANumberAndAUnit) {
  EXPECT_EQ(*ParseDuration("500ms"), 500'000'000U);
  EXPECT_EQ(*ParseDuration("60s"), 60'000'000'000U);
  EXPECT_EQ(*ParseDuration("15m"), 900'000'000'000U);
  EXPECT_EQ(*ParseDuration("1.5h"), 5'400'000'000'000U);
}

TEST(ParseDuration, RefusesEverythingElseAndSaysWhatItTakes) {
  for (const char* text :
       {"", "60", "s", "-1s", "0s", "1e9s", "nans", "inf", "1 s", "1d", "1s1", "1000h", "١s"}) {
    const auto duration = ParseDuration(text);
    ASSERT_FALSE(duration.ok()) << text;
    EXPECT_NE(duration.status().message().find("15m"), std::string::npos) << text;
  }
}

TEST(PrintJson, ReplacesWhatIsNoUtf8) {
  std::ostringstream out;
  PrintJson({{"scene", "a\xff"}}, out, -1);
  EXPECT_EQ(out.str(), "{\"scene\":\"a\uFFFD\"}\n");
}

TEST(BeliefsText, ListsTheArmsBestFirst) {
  const ArmBelief beliefs[] = {{"SAP", 1, 1}, {"Grid", 4.5, 1.5}, {"KDTree", 19.5, 4.5}};
  EXPECT_EQ(BeliefsText(beliefs), "KDTree 0.81 (n 24) · Grid 0.75 (6) · SAP 0.50 (2)");
  EXPECT_EQ(BeliefsText({}), "");
}

TEST(DroppedText, SaysWhatALossMeans) {
  EXPECT_EQ(DroppedText(0, 10), "no samples dropped");
  const std::string text = DroppedText(3, 10);
  EXPECT_NE(text.find("3 of 10 samples"), std::string::npos) << text;
  EXPECT_NE(text.find("frames themselves were not affected"), std::string::npos) << text;
}

TEST(CutToColumns, CutsBetweenCharacters) {
  EXPECT_EQ(CutToColumns("a · b", 9), "a · b");
  EXPECT_EQ(CutToColumns("a · b", 3), "a ·");
  EXPECT_EQ(CutToColumns("a · b", 2), "a ");
  EXPECT_EQ(CutToColumns("a · b", 0), "");
}

TEST(CommandLine, QuotesWhatAShellWouldReadOtherwise) {
  std::string words[] = {"./sweepstake", "--scene=a,b", "", "my file", "it's", "$HOME"};
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  EXPECT_EQ(CommandLine(pointers), "./sweepstake --scene=a,b '' 'my file' 'it'\\''s' '$HOME'");
  EXPECT_EQ(CommandLine({}), "");
}

TEST(QuoteCsv, QuotesCommasQuotesAndLineBreaksAsRfc4180Does) {
  EXPECT_EQ(QuoteCsv("SAP"), "SAP");
  EXPECT_EQ(QuoteCsv("a,b"), "\"a,b\"");
  EXPECT_EQ(QuoteCsv("a\"b"), "\"a\"\"b\"");
  EXPECT_EQ(QuoteCsv("a\nb"), "\"a\nb\"");
}

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
  EXPECT_FALSE(std::filesystem::exists(path));
  EXPECT_TRUE(kept->Commit().ok());
  std::stringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  EXPECT_EQ(text.str(), "a,b\r\n1,\"x,y\"\r\n");
  std::filesystem::remove(path);
}

TEST(CsvFile, SaysWhichFileCannotBeWritten) {
  const auto csv = CsvFile::Create("/nonexistent/x.csv", {"a"});
  ASSERT_FALSE(csv.ok());
  EXPECT_NE(csv.status().message().find("/nonexistent/x.csv"), std::string::npos);
}

}  // namespace
}  // namespace sweepstake::cli
