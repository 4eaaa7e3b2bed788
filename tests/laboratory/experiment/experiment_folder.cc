#include "tests/laboratory/experiment/experiment_folder.h"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "engine_client/cli/io/whole_file.h"
#include "engine_client/decider/options.h"
#include "sweepstake/machine_class.h"
#include "tests/laboratory/game/machine.h"

namespace sweepstake::cli {

// The JSON library finds these functions by the structs' namespace. The field names are those of
// the manifest.
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ExperimentOptions, scenes, object_counts, large_object_counts,
                                   policies, run_count, window, time_scale, seed, trace_frame_count,
                                   replay_seed_count, quick, frames)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ExperimentSession, command_line, start_utc, end_utc)

namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kManifestName = "manifest.json";
constexpr const char* kFolderFormat = "sweepstake-experiment";
constexpr int kFolderVersion = 1;

bool IsOfRun(const RunRecord& record, const PlannedRun& run) {
  return record.cell == run.cell && record.policy == run.policy && record.run == run.run &&
         record.seed == run.seed;
}

Json ClassedMachineJson() {
  Json machine = {{"class", MachineClass()}};
  machine.update(MachineJson(DescribeMachine()));
  return machine;
}

// Returns the parameters of the paper's mechanism after the time scale is applied.
Json DecisionJson(double time_scale) {
  const decision::DecisionOptions options = decision::DecisionOptions{}.Scaled(time_scale);
  return {{"decision_interval_ns", options.decision_interval_ns},
          {"cooldown_ns", options.cooldown_ns},
          {"settling_ns", options.settling_ns},
          {"bail_out_ns", options.bail_out_ns},
          {"exploration_warm_up_ns", options.exploration_warm_up_ns},
          {"exploration_measure_ns", options.exploration_measure_ns},
          {"bail_out_penalty", options.bail_out_penalty},
          {"fps_floor", options.fps_floor},
          {"weights",
           {{"fps", options.weights.fps},
            {"detection", options.weights.detection},
            {"memory", options.weights.memory},
            {"checks", options.weights.checks}}},
          {"priors", "Beta(1,1)"}};
}

Json RunsJson(const ExperimentPlan& plan) {
  Json runs = Json::array();
  for (const PlannedRun& run : plan.runs) {
    runs.push_back({{"run", run.label()},
                    {"scene_seed", run.cell.scene_seed},
                    {"decision_seed", run.seed},
                    {"initial_arm", run.initial_arm}});
  }
  return runs;
}

}  // namespace

std::filesystem::path ExperimentFolder::RunFile(const PlannedRun& run) const {
  return path_ / "runs" / (run.label() + ".json");
}

std::filesystem::path ExperimentFolder::FramesFile(const PlannedRun& run) const {
  return path_ / "frames" / (run.label() + ".csv");
}

std::filesystem::path ExperimentFolder::TraceFile(const ExperimentCell& cell) const {
  return path_ / "traces" / (cell.label() + ".costs");
}

Status ExperimentFolder::Create() const {
  if (std::filesystem::exists(path_ / kManifestName)) {
    return {StatusCode::kInvalidArgument,
            path_.string() + " already contains an experiment; continue it with --resume " +
                path_.string() + ", or choose another folder"};
  }
  for (const char* part : {"runs", "traces", "frames"}) {
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
  const std::filesystem::path file_path = path_ / kManifestName;
  std::ifstream file(file_path, std::ios::binary);
  if (!file) {
    return Status(StatusCode::kNotFound,
                  "there is no experiment in " + path_.string() + ": it has no " + kManifestName);
  }
  try {
    const nlohmann::json document = nlohmann::json::parse(file);
    if (document.at("format") != kFolderFormat || document.at("version") != kFolderVersion) {
      return Status(StatusCode::kDataLoss,
                    file_path.string() + " is the manifest of another program");
    }
    return ExperimentManifest{document.at("options").get<ExperimentOptions>(),
                              document.at("sittings").get<std::vector<ExperimentSession>>()};
  } catch (const nlohmann::json::exception& error) {
    return Status(StatusCode::kDataLoss, file_path.string() + " is broken: " + error.what());
  }
}

Status ExperimentFolder::WriteManifest(const std::string& json) const {
  auto file = WholeFile::Create(path_ / kManifestName);
  if (!file.ok()) return file.status();
  (*file)->Write(json);
  return (*file)->Commit();
}

std::vector<RunRecord> ExperimentFolder::ReadRecords(const ExperimentPlan& plan) const {
  std::vector<RunRecord> records;
  for (const PlannedRun& run : plan.runs) {
    auto record = ReadRecord(RunFile(run));
    if (record.ok() && IsOfRun(*record, run)) records.push_back(std::move(*record));
  }
  return records;
}

std::string ManifestJson(const ExperimentPlan& plan, const std::vector<ExperimentSession>& sessions,
                         size_t finished_count) {
  const Json manifest = {
      {"format", kFolderFormat},
      {"version", kFolderVersion},
      {"state", finished_count == plan.runs.size() ? "complete" : "partial"},
      {"finished_runs", finished_count},
      {"planned_runs", plan.runs.size()},
      {"options", Json(nlohmann::json(plan.options))},
      {"window_ns", plan.window_ns},
      {"decider", DecisionJson(plan.options.time_scale)},
      {"machine", ClassedMachineJson()},
      {"sittings", Json(nlohmann::json(sessions))},
      {"runs", RunsJson(plan)},
  };
  return manifest.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace sweepstake::cli
