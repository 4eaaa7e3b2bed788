// One live run of an experiment: a real GameRun with the embedded decider, from Beta(1,1), through
// the exploration and the observation window; then every arm alone on the same scene as a control.
//
// Uses the calling thread as the frame thread, and the session's sender thread. Frames are not
// paced.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "engine_client/cli/experiment/experiment_plan.h"
#include "engine_client/cli/experiment/experiment_record.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

struct LiveOptions {
  uint64_t window_ns = 0;  // of real time
  double time_scale = 1;
  std::filesystem::path frames_file;  // every frame's metrics as CSV; empty: none
  // Called between frames with the real time since the run began. Returns whether to go on.
  std::function<bool(uint64_t elapsed_ns)> go_on;
};

// Absent: go_on said no. The errors of OpenScene, MakeEmbeddedSession and CsvFile; kInternal: the
// exploration takes ten times as long as it should.
Result<std::optional<RunRecord>> PlayLive(const PlannedRun& planned, const LiveOptions& options);

}  // namespace sweepstake::cli
