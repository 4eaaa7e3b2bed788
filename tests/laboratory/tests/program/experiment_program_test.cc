// Tests `sweepstake-lab experiment` as users see it. Small scenes and a large time scale let a run
// take only a second. No times are compared.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/engine_client/cli/program/program.h"
#include "tests/support/file_text.h"

namespace sweepstake::cli {
namespace {

using nlohmann::json;
using test_support::FileText;
using testing::HasSubstr;

constexpr char kTiny[] =
    "experiment --scenes brownian --objects 60 --policies paper --time-scale 1000 --window 3m "
    "--trace-frames 64 --replay-seeds 2 ";

class ExperimentProgram : public testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove_all(folder_); }

  const std::filesystem::path folder_ = TemporaryPath("experiment");
};

TEST_F(ExperimentProgram, WritesTablesRawRowsAndManifest) {
  const ProgramRun run = RunLab(kTiny + std::string("--runs 2 --json --out ") + folder_.string());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json document = json::parse(run.out);
  EXPECT_EQ(document["complete"], true);
  ASSERT_EQ(document["rows"].size(), 1U);
  EXPECT_EQ(document["rows"][0]["runs"], 2);
  EXPECT_TRUE(document["rows"][0].contains("replay_regret"));
  for (const char* name :
       {"manifest.json", "tables.txt", "tables.csv", "activations.csv", "switches.csv",
        "decisions.csv", "posteriors.csv", "final.csv", "metrics.csv", "time.csv", "ranking.csv",
        "regret.csv", "agreement.csv", "comparisons.csv", "experiment.json",
        "traces/brownian-60-1.costs", "traces/brownian-60-2.costs", "runs/brownian-60-paper-1.json",
        "runs/brownian-60-paper-2.json"}) {
    EXPECT_GT(FileText(folder_ / name).size(), 60U) << name;
  }
  EXPECT_EQ(json::parse(FileText(folder_ / "experiment.json")), document);
  const bool has_page = run.err.find("built without the page") == std::string::npos;
  EXPECT_EQ(std::filesystem::exists(folder_ / "report.html"), has_page);
  const json manifest = json::parse(FileText(folder_ / "manifest.json"));
  EXPECT_EQ(manifest["state"], "complete");
  EXPECT_EQ(manifest["runs"].size(), 2U);
  EXPECT_THAT(manifest["sittings"][0]["command_line"].get<std::string>(), HasSubstr("--runs 2"));
  EXPECT_NE(manifest["sittings"][0]["end_utc"], "");
}

TEST_F(ExperimentProgram, PlaysATinyGridWithCrossoversAndOtherWork) {
  const ProgramRun run = RunLab(
      "experiment --grid crossovers --scenes storms --objects 60 --policies default --other-work "
      "1ms --time-scale 1000 --window 1m --trace-frames 64 --replay-seeds 2 --runs 1 --json "
      "--out " +
      folder_.string());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json document = json::parse(run.out);
  EXPECT_THAT(document["worth_text"].get<std::string>(), HasSubstr("on average over 1 cell"));
  EXPECT_TRUE(document["truths"][0]["worth"]["oracle_ms"].is_number());
  EXPECT_EQ(document["options"]["other_work"], "1ms");
}

TEST_F(ExperimentProgram, GoesOnWithWhatIsMissing) {
  ASSERT_EQ(RunLab(kTiny + std::string("--runs 2 --out ") + folder_.string()).exit_code, 0);
  const std::filesystem::path kept = folder_ / "runs" / "brownian-60-paper-1.json";
  const std::string before = FileText(kept);
  std::filesystem::remove(folder_ / "runs" / "brownian-60-paper-2.json");
  const ProgramRun run = RunLab("experiment --json --resume " + folder_.string());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(json::parse(run.out)["finished_runs"], 2);
  EXPECT_EQ(FileText(kept), before);
  EXPECT_EQ(json::parse(FileText(folder_ / "manifest.json"))["sittings"].size(), 2U);
}

TEST_F(ExperimentProgram, EndsWithWhatIsThereWhenInterrupted) {
  // The shell sends the signal when the first run has been written to disk.
  const std::string first = (folder_ / "runs" / "brownian-60-paper-1.json").string();
  const std::string out = folder_.string() + ".json";
  const std::string line = std::string(SWEEPSTAKE_LAB_PROGRAM) + " " + kTiny +
                           "--runs 60 --json --out '" + folder_.string() + "' >'" + out +
                           "' 2>/dev/null & child=$!; while [ ! -e '" + first +
                           "' ] && kill -0 $child; do sleep 0.05; done; kill -TERM $child; "
                           "wait $child";
  const int status = std::system(line.c_str());
  const json document = json::parse(FileText(out));
  std::filesystem::remove(out);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 1);
  EXPECT_EQ(document["complete"], false);
  EXPECT_GE(document["finished_runs"].get<size_t>(), 1U);
  EXPECT_THAT(FileText(folder_ / "tables.txt"), HasSubstr("PARTIAL"));
  EXPECT_EQ(json::parse(FileText(folder_ / "manifest.json"))["state"], "partial");
}

TEST_F(ExperimentProgram, BadUsageEndsWithTwoAndSaysWhatIsValid) {
  const std::string out = " --out " + folder_.string();
  ExpectBadUsage(RunLab, {
                             {"experiment", "--out DIR"},
                             {"experiment --resume a --out b", "either --out"},
                             {"experiment --resume " + folder_.string(),
                              "there is no manifest of an experiment"},
                             {"experiment --policies coin" + out, "paper"},
                             {"experiment --scenes nowhere" + out, "hurricane"},
                             {"experiment --window soon" + out, "60s"},
                             {"experiment --time-scale 0.5" + out, "--time-scale"},
                             {"experiment --runs 0" + out, "--runs"},
                             {"experiment --grid large" + out, "crossovers"},
                             {"experiment --cooldown soon" + out, "60s"},
                             {"experiment --weights 1,0,0" + out, "four numbers"},
                             {"experiment --weights 1,1,0,0" + out, "make them sum to 1"},
                             {"experiment --seed -1" + out, "negative"},
                             {"experiment --quick --out /dev/null/x", "/dev/null/x"},
                         });
  EXPECT_FALSE(std::filesystem::exists(folder_))
      << "nothing is created before all options are valid";
}

TEST_F(ExperimentProgram, HelpHasExamples) {
  const ProgramRun run = RunLab("experiment --help");
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.out, HasSubstr("sweepstake-lab experiment --time-scale 60 --out results"));
  EXPECT_THAT(run.out, HasSubstr("--resume"));
}

}  // namespace
}  // namespace sweepstake::cli
