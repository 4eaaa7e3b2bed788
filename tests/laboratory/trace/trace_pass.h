// Runs a scene once and times all arms on every frame.
//
// In every frame the arms take turns in a random order, so that disturbances of the machine and the
// cache contents left by the previous arm affect all of them alike. The control (a second structure
// of one arm) never runs directly before or after its twin. Before each measured call the boxes are
// written to memory, as a game has just done. Turns of 20 consecutive frames would give the same
// means but a higher 99th percentile, because every twentieth frame would start with cold caches.
//
// The scene advances in blocks of up to 20 frames whose boxes are kept. In every third block, fresh
// structures of the arms also run a burst (cost_trace.h) on the block's first frames. Very slow
// arms, except the control's twin, are measured once per block or less (trace_turns.h).
//
// Not thread-safe. Memory: a block of boxes, the structures, and 26 bytes per frame and arm.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "sweepstake/scene.h"
#include "sweepstake/status.h"
#include "tests/laboratory/trace/cost_trace.h"

namespace sweepstake::cli {

inline constexpr uint32_t kBurstFrames = 8;
inline constexpr uint32_t kBlocksPerBurst = 3;
// Steps of the scene before the trace's first frame, in which structures settle and caches warm up.
inline constexpr uint32_t kTraceWarmupFrames = 20;

struct TracePlan {
  std::vector<std::string> arms;  // known ones
  uint32_t control_arm = 0;
  std::vector<uint64_t> frame_ns;  // approximate time of a frame, per arm
  uint32_t frame_count = 0;
  uint64_t order_seed = 0;  // determines the order of the arms in each frame
};

// Returns the approximate time of a frame per arm, the minimum of a few frames. Steps the scene.
std::vector<uint64_t> ProbeArms(const std::vector<std::string>& arms, Scene& scene);

// Returns a trace that lacks only scene, seed, machine and repeat_count. Between blocks `on_frame`
// is called with the number of frames done. Error: kInternal (two arms found different numbers of
// pairs). REQUIRES: frame_count >= kBurstFrames; the scene is at its start, and its blocks hold at
// least kBurstFrames frames.
Result<CostTrace> RunTracePass(Scene& scene, const TracePlan& plan,
                               const std::function<void(uint32_t frames_done)>& on_frame);

}  // namespace sweepstake::cli
