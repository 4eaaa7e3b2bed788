// A scene's cost trace, merged from several runs.
//
// The scene is run `repeat_count` times, and every time in the trace is the lower quartile over the
// runs: what a backend does at a certain frame (a rebuild, a rebalanced tree) happens there in
// every run and stays; what disturbs the machine only ever adds time, somewhere else in every run,
// and goes unless it hits three runs in four. Where no run measured an arm in a frame, the
// arm counts as held. The control's twin is the arm that is cheapest in the scene's first frames.
//
// Not thread-safe. Cost: some 1.2 times the arms' frames per run, bursts included. Memory: 26 bytes
// per frame, arm and run.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "engine_client/cli/game/scene_choice.h"
#include "engine_client/cli/trace/cost_trace.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

// Up to this count, a block (frame_block.h) holds the frames of a burst.
inline constexpr uint32_t kMaxTracedObjects = 100'000;

struct TraceOptions {
  SceneChoice scene;
  std::vector<std::string> arms;  // as ChooseArms gives them
  uint32_t frame_count = 3000;    // kBurstFrames or more
  uint32_t repeat_count = 5;
};

// The errors of OpenScene and RunTracePass; kInvalidArgument: more than kMaxTracedObjects.
// `on_progress` hears the share that is done.
Result<CostTrace> RunTrace(const TraceOptions& options,
                           const std::function<void(double share)>& on_progress);

// One trace of several runs of a scene by the same arms. REQUIRES: one or more runs, of the same
// shape.
CostTrace MergeRuns(std::vector<CostTrace> runs);

}  // namespace sweepstake::cli
