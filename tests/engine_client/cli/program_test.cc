// The command line as scripts use it: words, exit codes, JSON.
#include "tests/engine_client/cli/program.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "sweepstake/broad_phase.h"
#include "sweepstake/scene.h"
#include "tests/engine_client/cli/well_formed.h"
#include "tests/support/pair_oracle.h"

namespace sweepstake::cli {
namespace {

using nlohmann::json;
using testing::HasSubstr;

// A file that goes with the test.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& name) : path_(TemporaryPath(name)) {}
  ~TemporaryFile() { std::filesystem::remove(path_); }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

TEST(Program, HelpOfEveryCommandEndsWithZeroAndShowsExamples) {
  for (const std::string command :
       {"run", "check", "bench", "pairs", "record", "replay", "trace", "watch", "paper-check"}) {
    const ProgramRun run = RunProgram(command + " --help");
    EXPECT_EQ(run.exit_code, 0) << command;
    EXPECT_THAT(run.out, HasSubstr("Examples:\n  sweepstake " + command)) << command;
    EXPECT_EQ(run.err, "");
  }
  EXPECT_EQ(RunProgram("--help").exit_code, 0);
  EXPECT_EQ(RunProgram("--version").exit_code, 0);
}

TEST(Program, BadUsageEndsWithTwoAndSaysWhatIsValid) {
  const struct {
    std::string arguments;
    std::string said;
  } cases[] = {
      {"", "the commands of sweepstake are run, check, "},
      {"frobnicate", "the commands of sweepstake are run, check"},
      {"pairs --scene suite-b --arm SAP --frame -3", "--frame"},
      {"record --scene suite-b --frames -1 --out x.aabbs", "--frames"},
      {"check", "--scene"},
      {"check --scene nowhere", "suite-h"},
      {"check --scene suite-b --arms Octree", "AxisSweep"},
      {"check --scene suite-b --objects -3", "--objects"},
      {"check --scene suite-b --seed -1", "--seed: -1 is negative"},
      {"pairs --scene suite-b --frame 0 --arm SAP --seed -1", "--seed: -1 is negative"},
      {"record --scene suite-b --frames 1 --out x.aabbs --seed -1", "--seed: -1 is negative"},
      {"check --scene all-coincident --objects 100000 --frames 0", "take fewer objects"},
      {"check --scene suite-b --objects 4000000000 --frames 1", "object_count"},
      {"bench --scene suite-b --threads 0", "--threads"},
      {"bench --scene suite-b --peer-cap nan", "--peer-cap: nan is no number"},
      {"bench --scene suite-b --threads 257", "--threads"},
      {"bench --scene suite-b --frames 0", "--frames"},
      {"bench --scene suite-b --seed -1", "--seed: -1 is negative"},
      {"bench --scene suite-b --peers --peer-cap 0", "--peer-cap"},
      {"bench --scene nowhere", "nearly-resting"},
      {"pairs --scene suite-b --frame 0 --arm Octree", "AxisSweep"},
      {"record --scene suite-b --frames 2 --out /nonexistent/x.aabbs", "/nonexistent"},
      {"bench --scene suite-b --colour", "--colour"},
      {"paper-check --seeds 0", "--seeds"},
  };
  for (const auto& [arguments, said] : cases) {
    const ProgramRun run = RunProgram(arguments);
    EXPECT_NE(run.exit_code, 0) << arguments;
    EXPECT_NE(run.exit_code, 1) << arguments;
    EXPECT_THAT(run.err, HasSubstr(said)) << arguments;
    EXPECT_EQ(run.out, "") << arguments;
  }
}

TEST(Program, PaperCheckJudgesTheNineCellsAndItsExitCodeSaysWhetherAllMatch) {
  const ProgramRun run = RunProgram("paper-check --seeds 1 --json");
  const auto document = nlohmann::json::parse(run.out);
  EXPECT_EQ(document["rows"].size(), 9U);
  EXPECT_EQ(run.exit_code, document["matches"].get<bool>() ? 0 : 1);
}

TEST(Program, CheckPassesEveryArmInDegenerateScenesAndMixtures) {
  const ProgramRun run =
      RunProgram("check --scene degenerate,mixtures --objects 120 --frames 25 --json");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const json document = json::parse(run.out);
  EXPECT_EQ(document["passed"], true);
  for (const json& row : document["rows"]) {
    EXPECT_EQ(row["passed"], true) << row;
    EXPECT_EQ(row["frames"], 26) << row;
  }
}

TEST(Program, CheckPassesEveryArmInAllEightScenes) {
  const ProgramRun run = RunProgram("check --scene all --objects 300 --frames 20 --json");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(json::parse(run.out)["rows"].size(), 8 * BroadPhaseNames().size());
}

TEST(Program, BenchPrintsARowPerSceneCountAndArmWithTheContractsColumns) {
  const ProgramRun run = RunProgram(
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

TEST(Program, BenchPrintsARowPerCountOfThreads) {
  const ProgramRun run = RunProgram(
      "bench --scene spawning --objects 3000 --frames 5 --arms Grid --threads 1,2,3 --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json rows = json::parse(run.out)["rows"];
  ASSERT_EQ(rows.size(), 3U);
  for (unsigned i = 0; i < 3; ++i) {
    EXPECT_EQ(rows[i]["threads"], i + 1);
    EXPECT_EQ(rows[i]["pairs_mean"], rows[0]["pairs_mean"]);
  }
}

TEST(Program, BenchComparesWithPeersOnTheSamePairs) {
  const ProgramRun run =
      RunProgram("bench --peers --scene suite-b --objects 300 --frames 5 --warmup 1 --json");
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

TEST(Program, BenchStopsAPeerAtItsCapAndSaysSo) {
  const ProgramRun run = RunProgram(
      "bench --peers --peer-cap 0.001 --scene suite-b --objects 2000 --frames 3 --arms SAP --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json document = json::parse(run.out);
  for (const json& row : document["rows"]) {
    if (row["kind"] == "arm") continue;
    EXPECT_EQ(row["frames"], 1) << row;
    EXPECT_THAT(row["note"].get<std::string>(), HasSubstr("cap")) << row;
  }
}

TEST(Program, BenchWritesItsReportAsOnePageWithTheRowsInIt) {
  const TemporaryFile page("bench.html");
  const ProgramRun run = RunProgram(
      "bench --scene suite-b --objects 50,100 --frames 3 --arms SAP,Grid --json --report " +
      page.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  std::stringstream text;
  text << std::ifstream(page.path()).rdbuf();
  const std::string html = text.str();
  EXPECT_EQ(test_support::FirstFlaw(html), "");
  EXPECT_THAT(html, HasSubstr("bench --scene suite-b --objects 50,100 --frames 3"));
  const std::string start = "id=\"bench-json\">";
  const size_t begin = html.find(start) + start.size();
  EXPECT_EQ(json::parse(html.substr(begin, html.find("</script>", begin) - begin)),
            json::parse(run.out));
}

TEST(Program, BenchRefusesAReportThatCannotBeWrittenBeforeItMeasures) {
  for (const std::string path : {"/nonexistent/x.html", "/tmp", "''"}) {
    const ProgramRun run =
        RunProgram("bench --scene suite-b --objects 1000000 --frames 1000000 --report " + path);
    EXPECT_EQ(run.exit_code, 2) << path;
    EXPECT_THAT(run.err, HasSubstr("cannot be written")) << path;
    EXPECT_EQ(run.out, "");
  }
}

TEST(Program, BenchPrintsATableForPeople) {
  const ProgramRun run =
      RunProgram("bench --scene suite-g --objects 3000 --frames 3 --arms SAP,BruteForce");
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.out, HasSubstr("ms_median"));
  EXPECT_THAT(run.out, HasSubstr("suite-g, 3000 objects, "));
  std::istringstream lines(run.out);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80U) << line;
}

TEST(Program, PairsOfARecordedFrameEqualBruteForceForEveryArm) {
  const TemporaryFile file("recorded.aabbs");
  ASSERT_EQ(
      RunProgram("record --scene hurricane --objects 300 --frames 6 --seed 4 --out " + file.path())
          .exit_code,
      0);
  const auto scene = std::move(*MakeScene(file.path(), {}));
  for (int step = 0; step < 5; ++step) scene->Step();
  std::ostringstream right;
  for (const OverlapPair& pair : test_support::ScalarPairs(scene->aabbs())) {
    right << pair.a << ' ' << pair.b << '\n';
  }
  for (const std::string_view arm : BroadPhaseNames()) {
    const ProgramRun run =
        RunProgram("pairs --scene " + file.path() + " --frame 5 --arm " + std::string(arm));
    EXPECT_EQ(run.exit_code, 0) << arm;
    EXPECT_EQ(run.out, right.str()) << arm;
  }
}

TEST(Program, RecordSaysWhatItWroteAsJson) {
  const TemporaryFile file("json.aabbs");
  const ProgramRun run =
      RunProgram("record --scene suite-b --objects 10 --frames 3 --json --out " + file.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json document = json::parse(run.out);
  EXPECT_EQ(document["bytes"], 304 + 4 * 10 * 32);
  EXPECT_EQ(document["bytes"], std::filesystem::file_size(file.path()));
}

TEST(Program, ABrokenFileGivesOneLineAndNoOutput) {
  const TemporaryFile file("broken.aabbs");
  std::ofstream(file.path(), std::ios::binary) << std::string(500, 'x');
  for (const std::string& command :
       std::vector<std::string>{"check", "bench", "pairs --frame 0 --arm SAP",
                                "record --frames 1 --out " + TemporaryPath("never.aabbs")}) {
    const ProgramRun run = RunProgram(command + " --scene " + file.path());
    EXPECT_EQ(run.exit_code, 2) << command;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_THAT(run.err, HasSubstr(file.path()));
    EXPECT_EQ(run.out, "");
  }
  EXPECT_FALSE(std::filesystem::exists(TemporaryPath("never.aabbs")));
}

}  // namespace
}  // namespace sweepstake::cli
