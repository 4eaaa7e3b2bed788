// Measures a scene's cost trace in several runs and merges them.
//
// The scene is run `repeat_count` times, and every time in the trace is the lower quartile over the
// runs. Work that a backend does at a certain frame (a rebuild, a rebalanced tree) occurs there in
// every run and is kept. A disturbance of the machine only adds time, at a different frame in every
// run, and disappears unless it affects three runs of four. An arm counts as held in a frame if no
// run measured it there. The control's twin is the arm that is cheapest in the scene's first
// frames.
//
// Not thread-safe. Cost: per run about 1.2 times the time of the arms' frames, bursts included.
// Memory: 26 bytes per frame, arm and run.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "engine_client/cli/game/scene_choice.h"
#include "sweepstake/status.h"
#include "tests/laboratory/trace/cost_trace.h"

namespace sweepstake::cli {

// The maximum object count at which a block (frame_block.h) still holds the frames of a burst.
inline constexpr uint32_t kMaxTracedObjects = 100'000;

struct TraceOptions {
  SceneChoice scene;
  std::vector<std::string> arms;  // as ChooseArms gives them
  uint32_t frame_count = 3000;    // kBurstFrames or more
  uint32_t repeat_count = 5;
};

// Measures the trace and calls `on_progress` with the share that is done. Errors: those of
// OpenScene and RunTracePass, and kInvalidArgument (more than kMaxTracedObjects objects).
Result<CostTrace> RunTrace(const TraceOptions& options,
                           const std::function<void(double share)>& on_progress);

// Merges several runs of a scene by the same arms. REQUIRES: at least one run; all have the same
// frames and arms.
CostTrace MergeRuns(std::vector<CostTrace> runs);

}  // namespace sweepstake::cli
