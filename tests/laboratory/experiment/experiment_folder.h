// The folder of an experiment: the path of each file, the manifest with the plan, and the finished
// runs. Files are written atomically, so that an experiment can be resumed after its program was
// killed.
//
//   manifest.json   options, seeds, machine, versions, command lines, state
//   runs/           one record per finished run
//   traces/         the costs of every arm on every frame of each scene
//   *.csv, tables.txt, experiment.json, report.html
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "engine_client/cli/game/game_run.h"
#include "sweepstake/status.h"
#include "tests/laboratory/experiment/experiment_plan.h"

namespace sweepstake {
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RewardWeights, fps, detection, memory, checks)
}  // namespace sweepstake

namespace sweepstake::decision {

// The options of the decider that an experiment can set.
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(DecisionOptions, weights, decision_interval_ns, cooldown_ns,
                                   settling_ns)

}  // namespace sweepstake::decision

namespace sweepstake::cli {

// The record of one live run, stored as a JSON file. The tables, the CSV files and the report are
// made from these records. Times are seconds or nanoseconds of real time since the run began (not
// multiplied by the time scale). Arms are indices in `arms`. Enumerations have the numbers of
// engine_client/decider/types.h.

struct RecordedSwitch {
  double time_s = 0;
  uint64_t frame = 0;  // the first frame on the new arm
  uint32_t from = 0;
  uint32_t to = 0;
  uint32_t reason = 0;       // SwitchReason
  uint64_t rebuild_ns = 0;   // time to build the structure, on the frame thread
  uint64_t settling_ns = 0;  // extra frame time until the arm settled; 0 if it never did
};

// One decision: a tick or a bail-out.
struct RecordedDecision {
  double time_s = 0;
  uint32_t active_arm = 0;
  int64_t candidate = -1;  // −1: there was none
  uint32_t outcome = 0;    // DecisionOutcome
  uint32_t reason = 0;     // SwitchReason of the commanded switch; 0: none
  double reward = -1;      // −1: there was no window to learn from
  uint32_t leader = 0;     // the arm with the highest P(best)
  double expected_loss_ratio = 0;
  uint32_t verdict = 0;  // Verdict
  // One value per arm; best_probability is empty if nothing was learnt yet.
  std::vector<double> alpha;
  std::vector<double> beta;
  std::vector<double> best_probability;
};

// The frames of one arm within about one decision interval.
struct MetricWindow {
  double time_s = 0;  // the window's end
  uint32_t arm = 0;
  uint64_t frame_count = 0;
  double frame_us_mean = 0;
  double frame_us_max = 0;
  double detection_us_mean = 0;
  double check_count_mean = 0;
  double pair_count_mean = 0;
  uint64_t native_bytes_max = 0;
  uint32_t object_count = 0;
};

// How the time of a run was spent. The first six values add up to the frames' time. intake_ns and
// decision_ns are times of the sender thread, lane_ns is the time of the shadow lane.
struct TimeShares {
  uint64_t scene_step_ns = 0;
  uint64_t detection_ns = 0;  // update and search, without rebuild frames
  uint64_t rebuild_ns = 0;    // update and search in frames that built the structure
  uint64_t copying_ns = 0;    // boxes for the shadow lane
  uint64_t around_ns = 0;     // the rest of the frame path: descriptors, switches
  uint64_t frame_end_ns = 0;  // sample, queue, bail-out guard
  uint64_t intake_ns = 0;     // passing frames from the queue to the decider's window
  uint64_t decision_ns = 0;   // the selector
  uint64_t longest_decision_ns = 0;
  uint64_t lane_ns = 0;  // the shadow lane's visits and preparations
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(TimeShares, scene_step_ns, detection_ns, rebuild_ns, copying_ns,
                                   around_ns, frame_end_ns, intake_ns, decision_ns,
                                   longest_decision_ns, lane_ns)

struct RunRecord : PlannedRun {
  double time_scale = 1;
  std::string start_utc;
  std::vector<std::string> arms;

  double exploration_s = 0;  // when the observation window began
  double end_s = 0;          // when the observation window ended
  std::vector<RecordedSwitch> switches;
  std::vector<RecordedDecision> decisions;
  std::vector<MetricWindow> windows;
  std::vector<ArmActivity> explored;  // per arm, before the observation window
  std::vector<ArmActivity> observed;  // per arm, in the observation window
  // Per arm: a control run of this arm alone on the same scene, right after the live run.
  std::vector<ArmActivity> controls;
  TimeShares time;
  uint64_t shadow_visit_count = 0;
  uint64_t warm_switch_count = 0;    // prepared by the shadow lane
  uint64_t dropped_frame_count = 0;  // dropped because the queue was full

  double observed_s() const { return end_s - exploration_s; }
};

// Writes and reads the file of a record, like WriteDocument and ReadDocument (io/document_file.h).
Status WriteRecord(const RunRecord& record, const std::filesystem::path& path);
Result<RunRecord> ReadRecord(const std::filesystem::path& path);

// One execution of the program on this experiment.
struct ExperimentSession {
  std::string command_line;
  std::string start_utc;
  std::string end_utc;  // empty if the program was killed
};

// Defines the JSON conversions, in the namespace of the structs because the JSON library searches
// there. The names of the fields are also their names in JSON.
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ExperimentOptions, scenes, object_counts, policies, run_count,
                                   window, time_scale, seed, trace_frame_count, replay_seed_count,
                                   decision, grid, other_work, quick)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ExperimentSession, command_line, start_utc, end_utc)

struct ExperimentManifest {
  ExperimentOptions options;  // defaults filled in
  std::vector<ExperimentSession> sessions;
};

class ExperimentFolder {
 public:
  explicit ExperimentFolder(std::filesystem::path path) : path_(std::move(path)) {}

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path RunFile(const PlannedRun& run) const;
  std::filesystem::path TraceFile(const PlannedScene& scene) const;

  // Creates the folders. Error: kInvalidArgument (a folder cannot be created, or the folder already
  // contains an experiment).
  Status Create() const;
  // Writes and reads the manifest, like WriteDocument and ReadDocument (io/document_file.h). It
  // contains the options, every run's seeds, the decider's scaled parameters, machine and versions.
  // `finished_count` is how many of the plan's runs are finished.
  Status WriteManifest(const ExperimentPlan& plan, const std::vector<ExperimentSession>& sessions,
                       size_t finished_count) const;
  Result<ExperimentManifest> ReadManifest() const;
  // Returns the records of the finished runs in the plan's order. A record that does not match its
  // file name is skipped, so its run is repeated.
  std::vector<RunRecord> ReadRecords(const ExperimentPlan& plan) const;

 private:
  std::filesystem::path path_;
};

}  // namespace sweepstake::cli
