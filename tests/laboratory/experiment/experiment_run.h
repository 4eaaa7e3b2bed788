// Runs an experiment: traces the scenes, plays the missing runs, and compares the runs with the
// traces.
//
// A live run is a real GameRun with the embedded decider, which starts from Beta(1,1) and goes
// through the exploration and the observation window. Then every arm runs alone on the same scene
// as a control. Frames are not paced. The calling thread is the frame thread; the session has its
// own sender thread.
//
// Each trace and each run is written to disk when it ends. All functions call `on_progress` with
// the finished share and the name of the current cell or run. They return early, without an error,
// if a stop was requested (process.h).
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sweepstake/frame_sample.h"
#include "sweepstake/status.h"
#include "tests/laboratory/experiment/experiment_folder.h"
#include "tests/laboratory/experiment/experiment_truth.h"

namespace sweepstake::cli {

using ExperimentProgress = std::function<void(double share, const std::string& text)>;

// Makes the missing traces. Errors: those of RunTrace and WriteCosts.
Status TraceCells(const ExperimentPlan& plan, const ExperimentFolder& folder,
                  const ExperimentProgress& on_progress);

// Plays the missing runs. Errors: those of PlayLive and of writing.
Status PlayGrid(const ExperimentPlan& plan, const ExperimentFolder& folder,
                const ExperimentProgress& on_progress);

// Returns the truths of the traced cells and the comparisons over all cells. Cells that come after
// a requested stop are not replayed and have only the figures of RankArms. Errors: those of
// AssessCell.
Result<ExperimentTruths> Assess(const ExperimentPlan& plan, const ExperimentFolder& folder,
                                std::span<const CellSummary> cells,
                                const ExperimentProgress& on_progress);

struct LiveOptions {
  uint64_t window_ns = 0;  // in real time
  double time_scale = 1;
  decision::DecisionOptions decision = {};  // before the time scale; `policy` is the run's
  uint64_t other_work_ns = 0;               // of the game, in each frame
  // Called between frames with the real time since the run began. The run stops if it returns
  // false.
  std::function<bool(uint64_t elapsed_ns)> go_on;
};

// Plays one run. Returns the record, or nothing if go_on returned false. Errors: those of OpenScene
// and MakeStudySession, and kInternal (the exploration takes ten times as long as planned).
Result<std::optional<RunRecord>> PlayLive(const PlannedRun& planned, const LiveOptions& options);

// Summarizes frames as windows: the means and extremes of the frames that ran on one arm within an
// interval. There is one window per interval and per change of arm. Not thread-safe.
class MetricWindowMeter {
 public:
  // REQUIRES: interval_ns > 0.
  explicit MetricWindowMeter(uint64_t interval_ns) : interval_ns_(interval_ns) {}

  // `now_ns` is the time from the run's start to the frame's end.
  void Add(const FrameSample& sample, uint64_t now_ns);
  // Returns the windows, including the current one.
  std::vector<MetricWindow> Take(uint64_t now_ns);

 private:
  void Close(uint64_t now_ns);

  const uint64_t interval_ns_;
  uint64_t begin_ns_ = 0;
  MetricWindow sums_;  // the means are sums until the window is closed
  std::vector<MetricWindow> windows_;
};

}  // namespace sweepstake::cli
