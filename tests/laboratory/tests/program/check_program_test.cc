// Tests the command line of `sweepstake-lab` as scripts use it: options, exit codes, JSON.
#include "tests/engine_client/cli/program/program.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "sweepstake/broad_phase.h"
#include "sweepstake/scene.h"
#include "tests/support/pair_oracle.h"

namespace sweepstake::cli {
namespace {

using nlohmann::json;
using testing::HasSubstr;

TEST(LabProgram, HelpOfEveryCommandEndsWithZeroAndShowsExamples) {
  for (const std::string command : {"check", "bench", "pairs", "record", "replay", "trace"}) {
    const ProgramRun run = RunLab(command + " --help");
    EXPECT_EQ(run.exit_code, 0) << command;
    EXPECT_THAT(run.out, HasSubstr("Examples:\n  sweepstake-lab " + command)) << command;
    EXPECT_EQ(run.err, "");
  }
  EXPECT_EQ(RunLab("--help").exit_code, 0);
  EXPECT_EQ(RunLab("--version").exit_code, 0);
}

TEST(LabProgram, BadUsageEndsWithTwoAndSaysWhatIsValid) {
  const struct {
    std::string arguments;
    std::string said;
  } cases[] = {
      {"", "the commands of sweepstake-lab are check, "},
      {"frobnicate", "unknown command of sweepstake-lab 'frobnicate', must be one of "},
      {"pairs --scene suite-b --arm SAP --frame -3", "--frame"},
      {"record --scene suite-b --frames -1 --out x.aabbs", "--frames"},
      {"check", "--scene"},
      {"check --scene nowhere", "suite-h"},
      {"check --scene suite-b --arms Octree", "AxisSweep"},
      {"check --scene suite-b --objects -3", "--objects"},
      {"check --scene suite-b --seed -1", "--seed: -1 is negative"},
      {"pairs --scene suite-b --frame 0 --arm SAP --seed -1", "--seed: -1 is negative"},
      {"record --scene suite-b --frames 1 --out x.aabbs --seed -1", "--seed: -1 is negative"},
      {"check --scene all-coincident --objects 100000 --frames 0", "use fewer --objects"},
      {"check --scene suite-b --objects 4000000000 --frames 1", "--objects"},
      {"bench --scene suite-b --threads 0", "--threads"},
      {"bench --scene suite-b --peer-cap nan", "--peer-cap: nan is not a number"},
      {"bench --scene suite-b --threads 257", "--threads"},
      {"bench --scene suite-b --frames 0", "--frames"},
      {"bench --scene suite-b --seed -1", "--seed: -1 is negative"},
      {"bench --scene suite-b --peers --peer-cap 0", "--peer-cap"},
      {"bench --scene nowhere", "nearly-resting"},
      {"pairs --scene suite-b --frame 0 --arm Octree", "AxisSweep"},
      {"record --scene suite-b --frames 2 --out /nonexistent/x.aabbs", "/nonexistent"},
      {"bench --scene suite-b --colour", "--colour"},
  };
  for (const auto& [arguments, said] : cases) {
    const ProgramRun run = RunLab(arguments);
    EXPECT_NE(run.exit_code, 0) << arguments;
    EXPECT_NE(run.exit_code, 1) << arguments;
    EXPECT_THAT(run.err, HasSubstr(said)) << arguments;
    EXPECT_EQ(run.out, "") << arguments;
  }
}

TEST(LabProgram, CheckPassesEveryArmInDegenerateScenesAndMixtures) {
  const ProgramRun run =
      RunLab("check --scene degenerate,mixtures --objects 120 --frames 25 --json");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const json document = json::parse(run.out);
  EXPECT_EQ(document["passed"], true);
  for (const json& row : document["rows"]) {
    EXPECT_EQ(row["passed"], true) << row;
    EXPECT_EQ(row["frames"], 26) << row;
  }
}

TEST(LabProgram, CheckPassesEveryArmInAllEightScenes) {
  const ProgramRun run = RunLab("check --scene all --objects 300 --frames 20 --json");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(json::parse(run.out)["rows"].size(), 8 * BroadPhaseNames().size());
}

TEST(LabProgram, PairsOfARecordedFrameEqualBruteForceForEveryArm) {
  const TemporaryFile file("recorded.aabbs");
  ASSERT_EQ(
      RunLab("record --scene hurricane --objects 300 --frames 6 --seed 4 --out " + file.path())
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
        RunLab("pairs --scene " + file.path() + " --frame 5 --arm " + std::string(arm));
    EXPECT_EQ(run.exit_code, 0) << arm;
    EXPECT_EQ(run.out, right.str()) << arm;
  }
}

TEST(LabProgram, RecordSaysWhatItWroteAsJson) {
  const TemporaryFile file("json.aabbs");
  const ProgramRun run =
      RunLab("record --scene suite-b --objects 10 --frames 3 --json --out " + file.path());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json document = json::parse(run.out);
  EXPECT_EQ(document["bytes"], 304 + 4 * 10 * 32);
  EXPECT_EQ(document["bytes"], std::filesystem::file_size(file.path()));
}

TEST(LabProgram, ABrokenFileGivesOneLineAndNoOutput) {
  const TemporaryFile file("broken.aabbs");
  std::ofstream(file.path(), std::ios::binary) << std::string(500, 'x');
  for (const std::string& command :
       std::vector<std::string>{"check", "bench", "pairs --frame 0 --arm SAP",
                                "record --frames 1 --out " + TemporaryPath("never.aabbs")}) {
    const ProgramRun run = RunLab(command + " --scene " + file.path());
    EXPECT_EQ(run.exit_code, 2) << command;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_THAT(run.err, HasSubstr(file.path()));
    EXPECT_EQ(run.out, "");
  }
  EXPECT_FALSE(std::filesystem::exists(TemporaryPath("never.aabbs")));
}

}  // namespace
}  // namespace sweepstake::cli
