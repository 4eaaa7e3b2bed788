// Tests `sweepstake-lab bench` as scripts use it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "sweepstake/simd.h"
#include "tests/engine_client/cli/program/program.h"

namespace sweepstake::cli {
namespace {

using nlohmann::json;
using testing::HasSubstr;

TEST(BenchProgram, PrintsARowPerSceneCountAndArmWithTheContractsColumns) {
  const ProgramRun run = RunLab(
      "bench --scene suite-b,suite-h --objects 100,200 --frames 10 --warmup 2 --arms "
      "SAP,BruteForce "
      "--json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json rows = json::parse(run.out)["rows"];
  ASSERT_EQ(rows.size(), 8U);
  for (const char* column : {"scene", "objects", "arm", "threads", "frames", "ms_median", "ms_mean",
                             "ms_min", "ms_p99", "pairs_mean", "aabb_checks_mean", "bytes"}) {
    EXPECT_TRUE(rows[0].contains(column)) << column;
  }
  EXPECT_EQ(rows[0]["pairs_mean"], rows[1]["pairs_mean"]);
  EXPECT_EQ(rows[0]["frames"], 10);
}

constexpr const char* kSimdVariable = "SWEEPSTAKE_CLIENT_SIMD";

ProgramRun RunWithSimdVariable(const std::string& command, const std::string& value) {
  const char* const set = std::getenv(kSimdVariable);
  const std::string before = set == nullptr ? "" : set;
  setenv(kSimdVariable, value.c_str(), 1);
  ProgramRun run = RunLab(command);
  setenv(kSimdVariable, before.c_str(), 1);
  return run;
}

TEST(BenchProgram, RunsWithTheInstructionSetAskedForAndSaysWhich) {
  const std::string command = "bench --scene suite-b --objects 100 --frames 2 --arms SAP --json";
  const auto simd = [](const ProgramRun& run) {
    return json::parse(run.out)["machine"]["simd"].get<std::string>();
  };
  EXPECT_EQ(simd(RunWithSimdVariable(command, "")), SimdTargets().front());
  const std::string least(SimdTargets().back());
  EXPECT_EQ(simd(RunLab(command + " --simd " + least)), least);
  EXPECT_EQ(simd(RunWithSimdVariable(command, least)), least);
}

TEST(BenchProgram, RefusesAnInstructionSetThatTheMachineHasNot) {
  const std::string command = "bench --scene suite-b --objects 100 --frames 2 --arms SAP";
  for (const ProgramRun& run :
       {RunLab(command + " --simd mmx"), RunWithSimdVariable(command, "mmx"),
        RunLab(command + " --simd " + std::string(SimdTargets().front()) + ",mmx")}) {
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_THAT(run.err,
                HasSubstr("unknown instruction set of this machine 'mmx', must be one of"));
    EXPECT_THAT(run.err, HasSubstr(std::string(SimdTargets().front())));
    EXPECT_EQ(run.out, "") << "nothing is measured";
  }
}

TEST(BenchProgram, PrintsARowPerInstructionSet) {
  const ProgramRun run =
      RunLab("bench --scene suite-b --objects 300 --frames 5 --arms SAP,Grid --json --simd all");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json document = json::parse(run.out);
  const size_t count = SimdTargets().size();
  ASSERT_EQ(document["rows"].size(), 2 * count);
  ASSERT_EQ(document["simd"].size(), count);
  for (size_t i = 0; i < 2 * count; ++i) {
    EXPECT_EQ(document["rows"][i]["simd"], SimdTargets()[i % count]);
    EXPECT_EQ(document["rows"][i]["pairs_mean"], document["rows"][0]["pairs_mean"]);
  }
  const json& ratios = document["ratios"];
  ASSERT_EQ(ratios.size(), 2 * (count - 1)) << "each but the best with the next better one";
  for (const json& ratio : ratios) EXPECT_EQ(ratio["kind"], "simd");
  EXPECT_EQ(document["machine"]["simd"], SimdTargets().front());
}

TEST(BenchProgram, PrintsARowPerCountOfThreads) {
  const ProgramRun run =
      RunLab("bench --scene spawning --objects 3000 --frames 5 --arms Grid --threads 1,2,3 --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json rows = json::parse(run.out)["rows"];
  ASSERT_EQ(rows.size(), 3U);
  for (unsigned i = 0; i < 3; ++i) {
    EXPECT_EQ(rows[i]["threads"], i + 1);
    EXPECT_EQ(rows[i]["pairs_mean"], rows[0]["pairs_mean"]);
  }
}

TEST(BenchProgram, ComparesWithPeersOnTheSamePairs) {
  const ProgramRun run =
      RunLab("bench --peers --scene suite-b --objects 300 --frames 5 --warmup 1 --json");
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  const json document = json::parse(run.out);
  size_t peer_count = 0;
  for (const json& row : document["rows"]) {
    EXPECT_FALSE(row.contains("difference")) << row;
    EXPECT_EQ(row["pairs_mean"], document["rows"][0]["pairs_mean"]) << row;
    EXPECT_EQ(row["frames"], 5) << row;
    peer_count += row["kind"] == "peer" ? 1 : 0;
  }
  const size_t library_count =
      document["machine"]["libraries"].size() - 1 + document["machine"]["absent_peers"].size();
  EXPECT_EQ(library_count, 6U);
  EXPECT_GE(peer_count + document["machine"]["absent_peers"].size(), 6U);
  EXPECT_EQ(document["ratios"].empty(), peer_count == 0);
}

TEST(BenchProgram, StopsAPeerAtItsCapAndSaysSo) {
  const ProgramRun run = RunLab(
      "bench --peers --peer-cap 0.001 --scene suite-b --objects 2000 --frames 3 --arms SAP --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json document = json::parse(run.out);
  for (const json& row : document["rows"]) {
    if (row["kind"] == "arm") continue;
    EXPECT_EQ(row["frames"], 1) << row;
    EXPECT_THAT(row["note"].get<std::string>(), HasSubstr("cap")) << row;
  }
}

// Returns the documents in a report.
json DocumentsIn(const std::string& path) {
  std::stringstream text;
  text << std::ifstream(path).rdbuf();
  const std::string html = text.str();
  const std::string start = "id=\"documents\">";
  const size_t begin = html.find(start) + start.size();
  return json::parse(html.substr(begin, html.find("</script>", begin) - begin));
}

// A program that was built without Node has no page: it prints an error and writes nothing. If
// tests/run.sh has installed Node, that is a test failure.
bool HasNoPage(const ProgramRun& run, const std::string& path) {
  if (run.exit_code != 3) return false;
  EXPECT_EQ(std::getenv("REQUIRE_REPORT_PAGE"), nullptr) << run.err;
  EXPECT_THAT(run.err, HasSubstr("built without the page"));
  EXPECT_FALSE(std::filesystem::exists(path));
  return true;
}

TEST(ReportProgram, MakesTheSameReportFromSavedDocuments) {
  const TemporaryFile saved("bench.json"), page("report.html");
  const ProgramRun bench =
      RunLab("bench --scene suite-b --objects 50 --frames 3 --arms SAP --json");
  std::ofstream(saved.path()) << bench.out;
  const ProgramRun run =
      RunLab("report " + saved.path() + " " + saved.path() + " --out " + page.path());
  if (HasNoPage(run, page.path())) GTEST_SKIP() << "built without Node";
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json documents = DocumentsIn(page.path());
  ASSERT_EQ(documents.size(), 2U);
  EXPECT_EQ(documents[0], json::parse(bench.out));
  EXPECT_THAT(documents[0]["command_line"].get<std::string>(),
              HasSubstr("bench --scene suite-b --objects 50 --frames 3"));
}

TEST(ReportProgram, RefusesWhatIsNoDocument) {
  const TemporaryFile saved("other.json"), page("report.html");
  std::ofstream(saved.path()) << "{\"command\":\"watch\"}";
  for (const std::string& input : {saved.path(), std::string("/nonexistent.json")}) {
    const ProgramRun run = RunLab("report " + input + " --out " + page.path());
    EXPECT_EQ(run.exit_code, 2) << input;
    EXPECT_THAT(run.err, HasSubstr(input));
    EXPECT_FALSE(std::filesystem::exists(page.path()));
  }
}

TEST(ReportProgram, SaysWhatADocumentLacks) {
  const TemporaryFile saved("cut.json"), page("report.html");
  const std::pair<const char*, const char*> documents[] = {
      {R"({"command":"bench"})", "has no rows"},
      {R"({"command":"bench","rows":[]})", "has no rows"},
      {R"({"command":7})", "is not a document of"}};
  for (const auto& [text, error] : documents) {
    std::ofstream(saved.path()) << text;
    const ProgramRun run = RunLab("report " + saved.path() + " --out " + page.path());
    EXPECT_EQ(run.exit_code, 2) << text;
    EXPECT_THAT(run.err, HasSubstr(error));
    EXPECT_FALSE(std::filesystem::exists(page.path()));
  }
}

TEST(ReportProgram, DoesNotReplaceItsDocument) {
  const TemporaryFile saved("kept.json");
  const std::string text = R"({"command":"replay","rows":[{}]})";
  std::ofstream(saved.path()) << text;
  const ProgramRun run = RunLab("report " + saved.path() + " --out " + saved.path());
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("would overwrite a document"));
  std::ifstream file(saved.path());
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), text);
}

TEST(BenchProgram, PrintsATableForPeople) {
  const ProgramRun run =
      RunLab("bench --scene suite-g --objects 3000 --frames 3 --arms SAP,BruteForce");
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.out, HasSubstr("ms_median"));
  EXPECT_THAT(run.out, HasSubstr("suite-g, 3000 objects, "));
  std::istringstream lines(run.out);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80U) << line;
}

}  // namespace
}  // namespace sweepstake::cli
