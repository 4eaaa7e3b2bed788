#include "tests/laboratory/experiment/experiment_record.h"

#include <fstream>
#include <nlohmann/json.hpp>

#include "engine_client/cli/io/whole_file.h"

namespace sweepstake::cli {

// The JSON library finds these functions by the structs' namespace. The field names are those of
// the file.
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ExperimentCell, scene, object_count, scene_seed)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RecordedSwitch, time_s, frame, from, to, reason, rebuild_ns,
                                   settling_ns)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RecordedDecision, time_s, active_arm, candidate, outcome, reason,
                                   reward, leader, expected_loss_ratio, verdict, alpha, beta,
                                   best_probability)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(MetricWindow, time_s, arm, frame_count, frame_us_mean,
                                   frame_us_max, detection_us_mean, check_count_mean,
                                   pair_count_mean, native_bytes_max, object_count)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ArmTotals, frame_count, frame_ns, detection_ns)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(TimeShares, scene_step_ns, detection_ns, rebuild_ns, copying_ns,
                                   around_ns, frame_end_ns, intake_ns, decision_ns,
                                   longest_decision_ns, lane_ns)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ArmControl, frame_count, detection_ns_mean, frame_ns_mean)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RunRecord, cell, policy, run, seed, initial_arm, time_scale,
                                   start_utc, arms, exploration_s, end_s, switches, decisions,
                                   windows, explored, observed, controls, time, shadow_visit_count,
                                   warm_switch_count, dropped_frame_count)

namespace {

constexpr const char* kRunFormat = "sweepstake-experiment-run";
constexpr int kRunVersion = 1;

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

}  // namespace

std::string RunLabel(const RunRecord& record) {
  return record.cell.label() + "-" + record.policy + "-" + std::to_string(record.run);
}

Status WriteRecord(const RunRecord& record, const std::filesystem::path& path) {
  auto file = WholeFile::Create(path);
  if (!file.ok()) return file.status();
  const nlohmann::json document = {
      {"format", kRunFormat}, {"version", kRunVersion}, {"run", record}};
  (*file)->Write(document.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
  return (*file)->Commit();
}

Result<RunRecord> ReadRecord(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) return Status(StatusCode::kNotFound, path.string() + " cannot be read");
  const auto broken = [&](const std::string& what) {
    return Status(StatusCode::kDataLoss, path.string() + " is not a record of a run: " + what);
  };
  try {
    const nlohmann::json document = nlohmann::json::parse(file);
    if (document.at("format") != kRunFormat || document.at("version") != kRunVersion) {
      return broken("its format or version is not supported");
    }
    RunRecord record = document.at("run").get<RunRecord>();
    if (!IsConsistent(record)) return broken("the lengths of its lists do not match");
    return record;
  } catch (const nlohmann::json::exception& error) {
    return broken(error.what());
  }
}

}  // namespace sweepstake::cli
