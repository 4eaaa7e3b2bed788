#include "tests/laboratory/experiment/experiment_folder.h"

#include <algorithm>
#include <system_error>

#include "engine_client/cli/io/json_output.h"
#include "engine_client/decider/options.h"
#include "sweepstake/machine_class.h"
#include "tests/laboratory/game/machine.h"
#include "tests/laboratory/io/document_file.h"
#include "tests/laboratory/replay/replay_output.h"

namespace sweepstake::cli {

// Defines the JSON conversions, in the namespace of the structs because the JSON library searches
// there. The names of the fields are also their names in the file.
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ExperimentCell, scene, object_count)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RecordedSwitch, time_s, frame, from, to, reason, rebuild_ns,
                                   settling_ns)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RecordedDecision, time_s, active_arm, candidate, outcome, reason,
                                   reward, leader, expected_loss_ratio, verdict, alpha, beta,
                                   best_probability)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(MetricWindow, time_s, arm, frame_count, frame_us_mean,
                                   frame_us_max, detection_us_mean, check_count_mean,
                                   pair_count_mean, native_bytes_max, object_count)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ArmActivity, frame_count, active_ns, detection_ns)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RunRecord, cell, policy, run, scene_seed, seed, initial_arm,
                                   time_scale, start_utc, arms, exploration_s, end_s, switches,
                                   decisions, windows, explored, observed, controls, time,
                                   shadow_visit_count, warm_switch_count, dropped_frame_count)

namespace {

constexpr const char* kManifestName = "manifest.json";
constexpr DocumentFormat kFormat{.name = "sweepstake-experiment",
                                 .version = 2,
                                 .kind = "manifest of an experiment",
                                 .is_indented = true};

constexpr DocumentFormat kRunFormat{
    .name = "sweepstake-experiment-run", .version = 2, .kind = "record of a run"};

// Returns whether all lists and arm indices match the number of arms, since later code indexes by
// arm without checks.
bool IsConsistent(const RunRecord& record) {
  const size_t arms = record.arms.size();
  if (arms == 0 || record.explored.size() != arms || record.observed.size() != arms ||
      record.controls.size() != arms || record.initial_arm >= arms) {
    return false;
  }
  for (const RecordedSwitch& each : record.switches) {
    if (each.from >= arms || each.to >= arms) return false;
  }
  for (const MetricWindow& window : record.windows) {
    if (window.arm >= arms) return false;
  }
  for (const RecordedDecision& each : record.decisions) {
    const bool has_chances = each.best_probability.empty() || each.best_probability.size() == arms;
    if (each.active_arm >= arms || each.leader >= arms || !has_chances ||
        each.candidate >= static_cast<int64_t>(arms) || each.alpha.size() != arms ||
        each.beta.size() != arms) {
      return false;
    }
  }
  return true;
}

Json ClassedMachineJson() {
  Json machine = {{"class", MachineClass()}};
  machine.update(MachineJson(DescribeMachine()));
  return machine;
}

Json RunsJson(const ExperimentPlan& plan) {
  Json runs = Json::array();
  for (const PlannedRun& run : plan.runs) {
    runs.push_back({{"run", run.label()},
                    {"scene_seed", run.scene_seed},
                    {"decision_seed", run.seed},
                    {"initial_arm", run.initial_arm}});
  }
  return runs;
}

}  // namespace

std::filesystem::path ExperimentFolder::RunFile(const PlannedRun& run) const {
  return path_ / "runs" / (run.label() + ".json");
}

std::filesystem::path ExperimentFolder::TraceFile(const PlannedScene& scene) const {
  return path_ / "traces" / (scene.label() + ".costs");
}

Status ExperimentFolder::Create() const {
  if (std::filesystem::exists(path_ / kManifestName)) {
    return {StatusCode::kInvalidArgument,
            path_.string() + " already contains an experiment; continue it with --resume " +
                path_.string() + ", or choose another folder"};
  }
  for (const char* part : {"runs", "traces"}) {
    std::error_code error;
    std::filesystem::create_directories(path_ / part, error);
    if (error) {
      return {StatusCode::kInvalidArgument,
              path_.string() + " could not be created: " + error.message()};
    }
  }
  return {};
}

Result<ExperimentManifest> ExperimentFolder::ReadManifest() const {
  ExperimentManifest manifest;
  Status status = ReadDocument(path_ / kManifestName, kFormat, [&](const nlohmann::json& document) {
    document.at("options").get_to(manifest.options);
    document.at("sittings").get_to(manifest.sessions);
    return "";
  });
  if (!status.ok()) return status;
  return manifest;
}

Status ExperimentFolder::WriteManifest(const ExperimentPlan& plan,
                                       const std::vector<ExperimentSession>& sessions,
                                       size_t finished_count) const {
  return WriteDocument(
      path_ / kManifestName, kFormat,
      {{"state", finished_count == plan.runs.size() ? "complete" : "partial"},
       {"finished_runs", finished_count},
       {"planned_runs", plan.runs.size()},
       {"options", nlohmann::json(plan.options)},
       {"window_ns", plan.window_ns},
       {"decider", DecisionJson(plan.options.decision.Scaled(plan.options.time_scale))},
       {"priors", "Beta(1,1)"},
       {"machine", ClassedMachineJson()},
       {"sittings", nlohmann::json(sessions)},
       {"runs", RunsJson(plan)}});
}

std::vector<RunRecord> ExperimentFolder::ReadRecords(const ExperimentPlan& plan) const {
  std::vector<RunRecord> records;
  for (const PlannedRun& run : plan.runs) {
    auto record = ReadRecord(RunFile(run));
    if (record.ok() && *record == run) records.push_back(std::move(*record));
  }
  return records;
}

Status WriteRecord(const RunRecord& record, const std::filesystem::path& path) {
  return WriteDocument(path, kRunFormat, {{"run", nlohmann::json(record)}});
}

Result<RunRecord> ReadRecord(const std::filesystem::path& path) {
  RunRecord record;
  Status status =
      ReadDocument(path, kRunFormat, [&](const nlohmann::json& document) -> std::string {
        document.at("run").get_to(record);
        return IsConsistent(record) ? "" : "its lists have different lengths";
      });
  if (!status.ok()) return status;
  return record;
}

}  // namespace sweepstake::cli
