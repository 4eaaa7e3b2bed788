// Tests `sweepstake-lab trace` as scripts use it. No times are compared.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "sweepstake/broad_phase.h"
#include "tests/engine_client/cli/program/program.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::cli {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class TraceProgram : public testing::Test {
 protected:
  std::string Place(const std::string& name) const { return (folder_.path() / name).string(); }

 private:
  test_support::TemporaryDirectory folder_;
};

TEST_F(TraceProgram, PrintsOneRowWithTheArmsTheControlAndTheOracle) {
  const ProgramRun run =
      RunLab("trace --scene suite-b --objects 200 --frames 80 --repeats 1 --json --out " +
             Place("b.costs"));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json document = json::parse(run.out);
  EXPECT_EQ(document["command"], "trace");
  ASSERT_EQ(document["rows"].size(), 1U);
  const json& row = document["rows"][0];
  EXPECT_EQ(row["scene"], "suite-b");
  EXPECT_EQ(row["objects"], 200);
  EXPECT_EQ(row["frames"], 80);
  EXPECT_EQ(row["bursts"], 2);
  EXPECT_EQ(row["file"], Place("b.costs"));
  EXPECT_GE(row["headroom_by_frame"].get<double>(), row["headroom_by_window"].get<double>());
  ASSERT_EQ(row["arms"].size(), BroadPhaseNames().size());
  double best = 0;
  for (const json& arm : row["arms"]) {
    for (const char* number : {"ms_mean", "ms_median", "ms_p99", "build_ms_median"}) {
      EXPECT_GT(arm[number].get<double>(), 0) << number;
    }
    best += arm["best_share"].get<double>();
  }
  EXPECT_NEAR(best, 1, 1e-9);
  EXPECT_LT(row["control"]["ci95"][0], row["control"]["ci95"][1]);
  EXPECT_TRUE(row["control"]["fair"].is_boolean());
}

TEST_F(TraceProgram, WritesAFileThatItReadsBackAsTheSameRow) {
  const ProgramRun made = RunLab(
      "trace --scene waves --objects 300 --frames 40 --repeats 2 --arms SAP,DBVT --json "
      "--seed 7 --out " +
      Place("w.costs"));
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const ProgramRun read = RunLab("trace --json --costs " + Place("w.costs"));
  ASSERT_EQ(read.exit_code, 0) << read.err;
  EXPECT_EQ(json::parse(read.out), json::parse(made.out));
}

TEST_F(TraceProgram, MakesAFolderWithAFilePerSceneAndCount) {
  const ProgramRun run =
      RunLab("trace --scene suite-b,storms --objects 50,60 --frames 8 --repeats 1 --seed 4 --out " +
             Place("traces"));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (const char* name : {"suite-b-50-4", "suite-b-60-4", "storms-50-4", "storms-60-4"}) {
    EXPECT_TRUE(std::filesystem::exists(Place("traces/" + std::string(name) + ".costs"))) << name;
  }
  EXPECT_THAT(run.out, HasSubstr("A/A control"));
  EXPECT_THAT(run.out, HasSubstr("Best fixed arm"));
  std::istringstream lines(run.out);
  for (std::string line; std::getline(lines, line);) {
    if (line.find(".costs") != std::string::npos) continue;
    EXPECT_LE(line.size(), 80U) << line;
  }
}

TEST_F(TraceProgram, SaysWhatIsWrongWithItsWords) {
  std::ofstream(Place("broken.costs")) << "SWPCOSTS";
  const std::string out = " --out " + Place("x.costs");
  ExpectBadUsage(
      RunLab,
      {
          {"trace", "give --scene to trace a scene, or --costs"},
          {"trace --scene suite-b", "--scene needs --out"},
          {"trace --scene suite-b --costs a.costs" + out,
           "give --scene to trace a scene, or --costs"},
          {"trace --costs a.costs" + out, "--costs must be without --out"},
          {"trace --scene nowhere" + out, "gather-and-scatter"},
          {"trace --scene suite-b --arms Octree" + out, "AxisSweep"},
          {"trace --scene suite-b --frames 7" + out, "--frames"},
          {"trace --scene suite-b --repeats 0" + out, "--repeats"},
          {"trace --scene suite-b --seed -1" + out, "--seed: -1 is negative"},
          {"trace --scene suite-b --objects 100001 --frames 8" + out, "at most 100000 objects"},
          {"trace --scene suite-b,suite-h" + out, "--out must be a folder"},
          {"trace --scene suite-b --frames 100000 --out /nonexistent/x.costs",
           "/nonexistent/x.costs"},
          {"trace --costs " + Place("none.costs"), "there is no cost trace"},
          {"trace --costs " + Place("broken.costs"), "is not a valid cost trace"},
      });
  EXPECT_FALSE(std::filesystem::exists(Place("x.costs")));
}

TEST_F(TraceProgram, LeavesNoFileBesideTheTraces) {
  EXPECT_EQ(RunLab("trace --scene suite-b --objects 200000 --out " + Place("x.costs")).exit_code,
            2);
  EXPECT_TRUE(std::filesystem::is_empty(std::filesystem::path(Place("x")).parent_path()));
}

}  // namespace
}  // namespace sweepstake::cli
