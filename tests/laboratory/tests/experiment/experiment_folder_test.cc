// Tests the folder of an interrupted experiment: which records are read, which are rejected, and
// how the experiment is resumed.
#include "tests/laboratory/experiment/experiment_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "engine_client/cli/io/process.h"
#include "engine_client/cli/io/terminal.h"
#include "tests/laboratory/tests/experiment/experiment_records.h"
#include "tests/laboratory/tests/lab_command.h"
#include "tests/laboratory/tests/trace/synthetic_trace.h"
#include "tests/laboratory/trace/cost_trace.h"
#include "tests/support/file_text.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::cli {
namespace {

using nlohmann::json;
using test_support::FileText;
using test_support::MakeRecord;
using test_support::TemporaryDirectory;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

void WriteFile(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

// Returns a plan of eight runs: two cells, two policies and two runs of each.
ExperimentPlan Plan() {
  ExperimentOptions options;
  options.scenes = {"brownian"};
  options.object_counts = {60, 80};
  options.policies = {"paper", "random"};
  options.run_count = 2;
  options.window = "100s";
  options.trace_frame_count = 64;
  options.replay_seed_count = 2;
  auto plan = MakePlan(options);
  EXPECT_TRUE(plan.ok()) << plan.status().message();
  return std::move(*plan);
}

class InterruptedExperiment : public testing::Test {
 protected:
  InterruptedExperiment() { EXPECT_TRUE(folder_.Create().ok()); }

  RunRecord RecordOf(const PlannedRun& run) const {
    RunRecord record = MakeRecord(run.cell, run.policy, run.run, 1, 60);
    static_cast<PlannedRun&>(record) = run;
    return record;
  }
  void Finish(const PlannedRun& run) {
    EXPECT_TRUE(WriteRecord(RecordOf(run), folder_.RunFile(run)).ok());
  }
  // Writes a trace for each scene. As in the records, KDTree is the fastest arm.
  void TraceAll() {
    constexpr uint64_t kCostsNs[] = {50'000, 25'000, 50'000};
    SyntheticTrace trace;
    trace.arms = test_support::kRecordArms;
    trace.detection_ns = [&](uint32_t, uint32_t arm) { return kCostsNs[arm]; };
    for (const PlannedScene& scene : plan_.scenes) {
      CostTrace costs = MakeTrace(trace);
      costs.seed = scene.seed;
      EXPECT_TRUE(WriteCosts(folder_.TraceFile(scene), costs).ok());
    }
  }
  void WriteManifest(size_t finished_count) {
    EXPECT_TRUE(
        folder_.WriteManifest(plan_, {{"sweepstake-lab experiment", "start", ""}}, finished_count)
            .ok());
  }
  json Manifest() const { return json::parse(FileText(folder_.path() / "manifest.json")); }

  const TemporaryDirectory root_;
  const ExperimentFolder folder_{root_.path() / "out"};
  const ExperimentPlan plan_ = Plan();
};

TEST_F(InterruptedExperiment, FindsItsRunsInTheOrderOfThePlan) {
  Finish(plan_.runs[6]);
  Finish(plan_.runs[1]);
  Finish(plan_.runs[4]);
  const auto records = folder_.ReadRecords(plan_);
  ASSERT_EQ(records.size(), 3U);
  EXPECT_EQ(records[0].label(), "brownian-60-random-1");
  EXPECT_EQ(records[1].label(), "brownian-80-paper-1");
  EXPECT_EQ(records[2].label(), "brownian-80-paper-2");
}

TEST_F(InterruptedExperiment, PlaysAgainWhatIsOfAnotherRun) {
  const PlannedRun& run = plan_.runs[0];
  const auto is_found = [&](const auto& change) {
    RunRecord record = RecordOf(run);
    change(record);
    EXPECT_TRUE(WriteRecord(record, folder_.RunFile(run)).ok());
    return folder_.ReadRecords(plan_).size() == 1;
  };
  EXPECT_TRUE(is_found([](RunRecord&) {}));
  EXPECT_FALSE(is_found([](RunRecord& record) { ++record.seed; }));
  EXPECT_FALSE(is_found([](RunRecord& record) { record.run = 2; }));
  EXPECT_FALSE(is_found([](RunRecord& record) { record.policy = "random"; }));
  EXPECT_FALSE(is_found([](RunRecord& record) { record.cell.object_count = 80; }));
  EXPECT_FALSE(is_found([](RunRecord& record) { ++record.scene_seed; }));
}

TEST_F(InterruptedExperiment, ARecordThatIsCutOffAnywhereIsNoRecord) {
  const PlannedRun& run = plan_.runs[0];
  Finish(run);
  const std::string whole = FileText(folder_.RunFile(run));
  ASSERT_GT(whole.size(), 1000U);
  // The last character is a newline, which the record does not need.
  for (size_t size = 0; size + 1 < whole.size(); size += 97) {
    WriteFile(folder_.RunFile(run), whole.substr(0, size));
    EXPECT_EQ(ReadRecord(folder_.RunFile(run)).status().code(), StatusCode::kDataLoss) << size;
  }
  EXPECT_TRUE(folder_.ReadRecords(plan_).empty());
  WriteFile(folder_.RunFile(run), whole);
  EXPECT_EQ(folder_.ReadRecords(plan_).size(), 1U);
}

TEST_F(InterruptedExperiment, ARecordOfAnotherFormatIsRefusedAndNamed) {
  const std::filesystem::path path = folder_.RunFile(plan_.runs[0]);
  Finish(plan_.runs[0]);
  const json whole = json::parse(FileText(path));
  const auto message = [&](const auto& change) {
    json document = whole;
    change(document);
    WriteFile(path, document.dump());
    return ReadRecord(path).status().message();
  };
  EXPECT_EQ(message([](json&) {}), "");
  EXPECT_THAT(message([](json& d) { d["format"] = "other"; }),
              HasSubstr("its format or version is not supported"));
  EXPECT_THAT(message([](json& d) { d["version"] = 1; }),
              HasSubstr("its format or version is not supported"));
  EXPECT_THAT(message([](json& d) { d["run"].erase("switches"); }), HasSubstr("switches"));
  EXPECT_THAT(message([](json& d) { d["run"]["arms"] = 3; }), StartsWith(path.string()));
  EXPECT_THAT(message([](json& d) { d = json::array(); }),
              HasSubstr("is not a valid record of a run"));
}

TEST_F(InterruptedExperiment, ARecordWhoseListsDoNotFitIsRefused) {
  const std::filesystem::path path = root_.path() / "x.json";
  const auto is_read = [&](const auto& change) {
    RunRecord record = RecordOf(plan_.runs[0]);
    change(record);
    EXPECT_TRUE(WriteRecord(record, path).ok());
    return ReadRecord(path).ok();
  };
  EXPECT_TRUE(is_read([](RunRecord&) {}));
  EXPECT_TRUE(is_read([](RunRecord& r) { r.decisions[0].best_probability.clear(); }));
  EXPECT_TRUE(is_read([](RunRecord& r) { r.decisions[0].candidate = -1; }));
  EXPECT_FALSE(is_read([](RunRecord& r) { r.decisions[0].candidate = 3; }));
  EXPECT_FALSE(is_read([](RunRecord& r) { r.decisions[0].leader = 3; }));
  EXPECT_FALSE(is_read([](RunRecord& r) { r.decisions[0].active_arm = 3; }));
  EXPECT_FALSE(is_read([](RunRecord& r) { r.decisions[0].best_probability.pop_back(); }));
  EXPECT_FALSE(is_read([](RunRecord& r) { r.decisions[0].beta.push_back(1); }));
  EXPECT_FALSE(is_read([](RunRecord& r) { r.initial_arm = 3; }));
  EXPECT_FALSE(is_read([](RunRecord& r) { r.switches[0].from = 3; }));
  EXPECT_FALSE(is_read([](RunRecord& r) { r.switches[0].to = 3; }));
  EXPECT_FALSE(is_read([](RunRecord& r) { r.windows[0].arm = 7; }));
  EXPECT_FALSE(is_read([](RunRecord& r) { r.explored.pop_back(); }));
  EXPECT_FALSE(is_read([](RunRecord& r) { r.observed.push_back({}); }));
  EXPECT_FALSE(is_read([](RunRecord& r) { r.controls.clear(); }));
  EXPECT_FALSE(is_read([](RunRecord& r) { r.arms.clear(); }));
  EXPECT_EQ(ReadRecord(root_.path() / "y.json").status().code(), StatusCode::kNotFound);
}

TEST_F(InterruptedExperiment, ItsManifestBringsEveryOptionBack) {
  ExperimentOptions options = plan_.options;
  options.time_scale = 12.5;
  options.seed = 9;
  options.grid = "crossovers";
  options.other_work = "2ms";
  options.decision.decision_interval_ns = 1'000'000'000;
  options.decision.cooldown_ns = 8'000'000'000;
  options.decision.settling_ns = 500'000'000;
  options.decision.weights = {.fps = 0, .detection = 1, .memory = 0, .checks = 0};
  auto plan = MakePlan(options);
  ASSERT_TRUE(plan.ok());
  ASSERT_TRUE(folder_.WriteManifest(*plan, {}, plan->runs.size()).ok());
  const auto read = folder_.ReadManifest();
  ASSERT_TRUE(read.ok()) << read.status().message();
  const auto again = MakePlan(read->options);
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(again->cells, plan->cells);
  EXPECT_EQ(again->window_ns, 8'000'000'000U);
  ASSERT_EQ(again->runs.size(), plan->runs.size());
  for (size_t i = 0; i < plan->runs.size(); ++i) {
    EXPECT_EQ(again->runs[i].label(), plan->runs[i].label());
    EXPECT_EQ(again->runs[i], plan->runs[i]);
  }
  EXPECT_EQ(read->options.replay_seed_count, 2U);
  EXPECT_EQ(read->options.decision.decision_interval_ns, 1'000'000'000);
  EXPECT_EQ(read->options.decision.cooldown_ns, 8'000'000'000);
  EXPECT_EQ(read->options.decision.settling_ns, 500'000'000);
  EXPECT_EQ(read->options.grid, "crossovers");
  EXPECT_EQ(again->other_work_ns, 2'000'000U) << "the time scale does not divide it";
  EXPECT_EQ(read->options.decision.weights.detection, 1);
  EXPECT_EQ(read->options.decision.weights.fps, 0);
  EXPECT_EQ(Manifest()["decider"]["decision_interval_ns"], 80'000'000) << "divided by 12.5";
  EXPECT_EQ(Manifest()["state"], "complete");
}

TEST_F(InterruptedExperiment, ItsManifestHoldsTheSeedsAndTheScaledParameters) {
  WriteManifest(3);
  const json manifest = Manifest();
  EXPECT_EQ(manifest["state"], "partial");
  EXPECT_EQ(manifest["finished_runs"], 3);
  EXPECT_EQ(manifest["planned_runs"], 8);
  EXPECT_EQ(manifest["decider"]["decision_interval_ns"], 2'000'000'000);
  EXPECT_EQ(manifest["decider"]["weights"]["fps"], 0.55);
  EXPECT_EQ(manifest["priors"], "Beta(1,1)");
  ASSERT_EQ(manifest["runs"].size(), plan_.runs.size());
  for (size_t i = 0; i < plan_.runs.size(); ++i) {
    EXPECT_EQ(manifest["runs"][i]["run"], plan_.runs[i].label());
    EXPECT_EQ(manifest["runs"][i]["scene_seed"], plan_.runs[i].scene_seed);
    EXPECT_EQ(manifest["runs"][i]["decision_seed"], plan_.runs[i].seed);
    EXPECT_EQ(manifest["runs"][i]["initial_arm"], plan_.runs[i].initial_arm);
  }
}

TEST_F(InterruptedExperiment, ABrokenManifestIsNamed) {
  WriteManifest(0);
  const std::filesystem::path path = folder_.path() / "manifest.json";
  const std::string whole = FileText(path);
  const auto status = [&](const std::string& text) {
    WriteFile(path, text);
    return folder_.ReadManifest().status();
  };
  EXPECT_TRUE(status(whole).ok());
  for (const size_t size : {size_t{0}, size_t{1}, whole.size() / 2, whole.size() - 3}) {
    EXPECT_EQ(status(whole.substr(0, size)).code(), StatusCode::kDataLoss) << size;
  }
  json document = json::parse(whole);
  document["options"].erase("window");
  EXPECT_THAT(status(document.dump()).message(),
              HasSubstr("manifest.json is not a valid manifest"));
  document = json::parse(whole);
  document["format"] = "sweepstake-experiment-run";
  EXPECT_THAT(status(document.dump()).message(),
              HasSubstr("its format or version is not supported"));
}

// All runs and traces exist, so nothing is played or timed.
TEST_F(InterruptedExperiment, ResumingACompleteOneOnlyMakesItsResults) {
  for (const PlannedRun& run : plan_.runs) Finish(run);
  TraceAll();
  WriteManifest(0);
  const std::string record = FileText(folder_.RunFile(plan_.runs[5]));
  const std::string trace = FileText(folder_.TraceFile(plan_.scenes[3]));
  const CommandRun run = RunLabCommand("experiment --json --resume " + folder_.path().string());
  ASSERT_EQ(run.exit_code, kDone) << run.err;
  const json document = json::parse(run.out);
  EXPECT_EQ(document["complete"], true);
  ASSERT_EQ(document["rows"].size(), 4U) << "a row per policy and cell";
  const char* const expected[][2] = {{"paper", "brownian-60"},
                                     {"paper", "brownian-80"},
                                     {"random", "brownian-60"},
                                     {"random", "brownian-80"}};
  for (size_t i = 0; i < 4; ++i) {
    const json& row = document["rows"][i];
    EXPECT_EQ(row["policy"], expected[i][0]) << i;
    EXPECT_EQ(row["cell"], expected[i][1]) << i;
    EXPECT_EQ(row["truly_fastest"], "KDTree") << i;
    EXPECT_EQ(row["runs"], 2) << i;
  }
  ASSERT_EQ(document["truths"].size(), 2U);
  EXPECT_EQ(document["truths"][1]["scenes"], 2);
  EXPECT_EQ(document["truths"][1]["comparisons"][0]["p_smallest"], 0.5) << "two scenes";
  EXPECT_EQ(FileText(folder_.RunFile(plan_.runs[5])), record);
  EXPECT_EQ(FileText(folder_.TraceFile(plan_.scenes[3])), trace);
  EXPECT_EQ(json::parse(FileText(folder_.path() / "experiment.json")), document);
  EXPECT_THAT(FileText(folder_.path() / "tables.txt"),
              AllOf(StartsWith("\nThe best sequence of algorithms saves "),
                    HasSubstr("Choosing is worth nothing (less than "),
                    HasSubstr("in 2 of 2 cells"), HasSubstr("\nTable 3. Dominant")));
  EXPECT_THAT(document["worth_text"].get<std::string>(), StartsWith("The best sequence"));
  EXPECT_EQ(Manifest()["state"], "complete");
  ASSERT_EQ(Manifest()["sittings"].size(), 2U);
  EXPECT_EQ(Manifest()["sittings"][0]["end_utc"], "") << "the first session was killed";
  EXPECT_NE(Manifest()["sittings"][1]["end_utc"], "");
}

// The signal arrives before the first trace. It stops a child process of the test.
TEST(StoppedExperimentDeathTest, LeavesAFolderThatSaysWhatWasAskedFor) {
  const TemporaryDirectory root;
  const std::filesystem::path out = root.path() / "out";
  const std::string line =
      "experiment --scenes brownian,hurricane --objects 60,80 --policies "
      "paper,adaptive-without-gate --runs 3 --window 2m --time-scale 500 --seed 5 --trace-frames "
      "64 --replay-seeds 2 --interval 1s --cooldown 8s --settling 500ms --weights 0.1,0.2,0.3,0.4 "
      "--out " +
      out.string();
  EXPECT_EXIT(
      {
        InstallStopSignal();
        std::raise(SIGTERM);
        std::_Exit(RunLabCommand(line).exit_code);
      },
      testing::ExitedWithCode(kCheckFailed), "");
  const auto manifest = ExperimentFolder(out).ReadManifest();
  ASSERT_TRUE(manifest.ok()) << manifest.status().message();
  const auto plan = MakePlan(manifest->options);
  ASSERT_TRUE(plan.ok());
  EXPECT_EQ(plan->runs.size(), 2U * 2 * 2 * 3);
  EXPECT_EQ(plan->runs[1].label(), "brownian-60-adaptive-without-gate-1");
  EXPECT_EQ(plan->cells[1].object_count, 80U);
  EXPECT_EQ(plan->options.seed, 5U);
  EXPECT_EQ(plan->options.decision.decision_interval_ns, 1'000'000'000);
  EXPECT_EQ(plan->options.decision.cooldown_ns, 8'000'000'000);
  EXPECT_EQ(plan->options.decision.settling_ns, 500'000'000);
  EXPECT_EQ(plan->options.decision.weights.memory, 0.3);
  EXPECT_EQ(plan->options.decision.weights.checks, 0.4);
  EXPECT_EQ(plan->window_ns, 240'000'000U);
  EXPECT_EQ(plan->options.trace_frame_count, 64U);
  EXPECT_EQ(plan->options.replay_seed_count, 2U);
  const json document = json::parse(FileText(out / "experiment.json"));
  EXPECT_EQ(document["complete"], false);
  EXPECT_EQ(document["finished_runs"], 0);
  EXPECT_EQ(document["planned_runs"], 24);
  EXPECT_TRUE(document["rows"].empty());
  EXPECT_EQ(document["cells"].size(), 4U);
  EXPECT_THAT(FileText(out / "tables.txt"),
              StartsWith("PARTIAL: 0 of 24 runs are finished; continue with --resume "));
}

}  // namespace
}  // namespace sweepstake::cli
