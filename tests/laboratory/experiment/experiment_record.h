// The record of one live run, from which the tables, the CSV files and the report are made. Plain
// data. Each run is stored as a JSON file of its own.
//
// Times are seconds or nanoseconds of real time since the run began (not multiplied by the time
// scale). Arms are indices in `arms`. Enumerations have the numbers of
// engine_client/decider/types.h.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sweepstake/status.h"
#include "tests/laboratory/experiment/experiment_plan.h"

namespace sweepstake::cli {

struct RecordedSwitch {
  double time_s = 0;
  uint64_t frame = 0;  // the first frame on the new arm
  uint32_t from = 0;
  uint32_t to = 0;
  uint32_t reason = 0;       // SwitchReason
  uint64_t rebuild_ns = 0;   // building the structure on the frame thread
  uint64_t settling_ns = 0;  // frame time above the settled mean; 0 also if it did not settle
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

// Sums over the frames of one arm.
struct ArmTotals {
  uint64_t frame_count = 0;
  uint64_t frame_ns = 0;
  uint64_t detection_ns = 0;
};

// How the time of a run was spent. The first six values add up to the frames' time; the next two
// are of the sender thread, and the last one is of the shadow lane.
struct TimeShares {
  uint64_t scene_step_ns = 0;
  uint64_t detection_ns = 0;  // update and search, without rebuild frames
  uint64_t rebuild_ns = 0;    // update and search in frames that built the structure
  uint64_t copying_ns = 0;    // boxes for the shadow lane
  uint64_t around_ns = 0;     // rest of the frame path: descriptors, switches
  uint64_t frame_end_ns = 0;  // sample, queue, bail-out guard
  uint64_t intake_ns = 0;     // queue to the decider's window
  uint64_t decision_ns = 0;   // the selector
  uint64_t longest_decision_ns = 0;
  uint64_t lane_ns = 0;  // the shadow lane's visits and preparations
};

// The cost of an arm under the run's conditions, measured alone on the same scene right after the
// run.
struct ArmControl {
  uint64_t frame_count = 0;
  double detection_ns_mean = 0;
  double frame_ns_mean = 0;
};

struct RunRecord {
  ExperimentCell cell;
  std::string policy;  // as given by the user
  uint32_t run = 0;
  uint64_t seed = 0;
  uint32_t initial_arm = 0;
  double time_scale = 1;
  std::string start_utc;
  std::vector<std::string> arms;

  double exploration_s = 0;  // when the observation window began
  double end_s = 0;          // when it ended
  std::vector<RecordedSwitch> switches;
  std::vector<RecordedDecision> decisions;
  std::vector<MetricWindow> windows;
  std::vector<ArmTotals> explored;   // per arm, before the observation window
  std::vector<ArmTotals> observed;   // per arm, in the observation window
  std::vector<ArmControl> controls;  // per arm
  TimeShares time;
  uint64_t shadow_visit_count = 0;
  uint64_t warm_switch_count = 0;    // prepared by the shadow lane
  uint64_t dropped_frame_count = 0;  // dropped because the queue was full

  double observed_s() const { return end_s - exploration_s; }
};

// Returns "brownian-1000-paper-1".
std::string RunLabel(const RunRecord& record);

// Writes the file, which appears whole or not at all. Errors: those of WholeFile.
Status WriteRecord(const RunRecord& record, const std::filesystem::path& path);
// Reads the file. Errors: kNotFound (no such file), kDataLoss (it is not a valid record).
Result<RunRecord> ReadRecord(const std::filesystem::path& path);

}  // namespace sweepstake::cli
