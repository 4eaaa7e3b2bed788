// Tests `sweepstake-lab replay` as scripts use it, on a trace from `sweepstake-lab trace`.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/engine_client/cli/program/program.h"

namespace sweepstake::cli {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

// A folder with brownian-100-1.costs.
class ReplayProgram : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder() = TemporaryPath("replay");
    std::filesystem::create_directory(folder());
    const ProgramRun run = RunLab(
        "trace --scene brownian --objects 100 --frames 80 --repeats 1 --arms BruteForce,Grid,SAP "
        "--out " +
        Costs());
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  static void TearDownTestSuite() { std::filesystem::remove_all(folder()); }

  static std::string& folder() {
    static std::string path;
    return path;
  }
  static std::string Costs() { return folder() + "/brownian-100-1.costs"; }
};

TEST_F(ReplayProgram, PrintsOneJsonDocumentWithTheRowsOfTheContract) {
  const ProgramRun run = RunLab("replay --costs " + Costs() +
                                " --policy paper,default,fixed:SAP,oracle --seeds 3 --run 2m "
                                "--json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json document = json::parse(run.out);
  EXPECT_EQ(document["command"], "replay");
  EXPECT_EQ(document["scenes"][0]["frames"], 12'000);
  EXPECT_THAT(document["scenes"][0]["arms"], ElementsAre("BruteForce", "Grid", "SAP"));
  ASSERT_EQ(document["rows"].size(), 4U);
  for (const json& row : document["rows"]) {
    EXPECT_EQ(row["costs"], Costs());
    EXPECT_EQ(row["seeds"], 3);
    EXPECT_EQ(row["ci95"].size(), 2U);
    for (const char* number :
         {"regret_best_fixed", "regret_oracle", "switches", "active_share", "headroom"}) {
      EXPECT_TRUE(row[number].is_number()) << number;
    }
    for (const char* name :
         {"policy", "dominant", "bail_outs", "headroom_captured", "regret_after_start"}) {
      EXPECT_TRUE(row.contains(name)) << name;
    }
  }
  EXPECT_TRUE(document["rows"][0]["bail_outs"].is_number());
  EXPECT_TRUE(document["rows"][3]["bail_outs"].is_null()) << "the oracle has none";
  EXPECT_EQ(document["rows"][0]["against_paper"]["difference"], 0);
}

TEST_F(ReplayProgram, TheTableNamesTheNoiseFloorAndEveryPolicy) {
  const ProgramRun run =
      RunLab("replay --costs " + Costs() + " --policy fixed,random --seeds 2 --run 20s");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  for (const char* word :
       {"noise floor", "fixed:BruteForce", "fixed:Grid", "fixed:SAP", "random", "switches"}) {
    EXPECT_THAT(run.out, HasSubstr(word));
  }
}

TEST_F(ReplayProgram, TheSameWhateverTheNumberOfThreads) {
  const std::string words =
      "replay --costs " + Costs() + " --policy paper,default --seeds 5 --run 2m --json --threads ";
  EXPECT_EQ(RunLab(words + "1").out, RunLab(words + "3").out);
}

TEST_F(ReplayProgram, RowsSayTheirPriorsAndTheirPassOfWhichEachTraceMayHaveItsOwn) {
  const ProgramRun run =
      RunLab("replay --costs " + Costs() + "," + Costs() +
             " --pass 90s,30s --policy random --seeds 2 --run 20s --priors wrong --interval 1s "
             "--settling 250ms --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json document = json::parse(run.out);
  EXPECT_EQ(document["decider"]["decision_interval_ns"], 1'000'000'000);
  EXPECT_EQ(document["decider"]["settling_ns"], 250'000'000);
  const json rows = document["rows"];
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0]["pass_ns"], 90'000'000'000);
  EXPECT_EQ(rows[1]["pass_ns"], 30'000'000'000);
  EXPECT_EQ(rows[0]["priors"], "wrong");
}

TEST_F(ReplayProgram, BadUsageEndsWithTwoAndSaysWhatIsValid) {
  ExpectBadUsage(
      [](const std::string& arguments) { return RunLab("replay " + arguments); },
      {
          {"", "give exactly one of --costs FILE.costs, --log FILE.csv and --recording FILE.aabbs"},
          {"--costs " + Costs() + " --log x.csv", "give exactly one of --costs"},
          {"--costs " + Costs() + " --pass 1m,2m,3m", "--pass has 3 durations for 1 trace;"},
          {"--costs " + Costs() + " --pass soon", "'soon' is not a duration"},
          {"--costs " + Costs() + " --policy pape", "must be one of paper, default, "},
          {"--costs " + Costs() + " --policy fixed:KDTree", "unknown traced arm 'KDTree'"},
          {"--costs " + Costs() + " --run 1", "'1' is not a duration"},
          {"--costs " + Costs() + " --interval 1", "--interval: '1' is not a duration"},
          {"--costs " + Costs() + " --weights 1,1,0,0", "make them sum to 1"},
          {"--costs " + Costs() + " --priors wright",
           "--priors: unknown value 'wright', must be one of right, none"},
          {"--costs " + Costs() + " --seeds 0", "--seeds"},
          {"--costs /nonexistent.costs", "/nonexistent.costs"},
      });
}

TEST_F(ReplayProgram, TracesWithOtherArmsAreRefusedTogether) {
  const std::string other = folder() + "/other.costs";
  ASSERT_EQ(RunLab("trace --scene brownian --objects 50 --frames 80 --repeats 1 --arms SAP,Grid "
                   "--out " +
                   other)
                .exit_code,
            0);
  const ProgramRun run = RunLab("replay --costs " + Costs() + "," + other);
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("replay them separately"));
}

}  // namespace
}  // namespace sweepstake::cli
