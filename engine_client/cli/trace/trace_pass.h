// One run of a scene in which all arms are timed on every frame.
//
// In every frame the arms take turns, in an order drawn anew: what disturbs the machine, and what
// one leaves in the caches for the next, hits all alike. The control (a second structure of one
// arm) never runs right after its twin nor right before it. Before each measured call its boxes are
// written to memory, as a game has just done. (Turns of 20
// frames on end would give the same means and a higher 99th percentile, because every twentieth
// frame would meet cold caches.)
//
// The scene advances in blocks of up to 20 frames whose boxes are kept: in every third block the
// arms also run a burst (cost_trace.h), by fresh structures, on the block's first frames; and very
// slow arms, but for the control's twin, are measured once per block or less (trace_turns.h).
//
// Not thread-safe. Memory: a block of boxes, the structures, and 26 bytes per frame and arm.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "engine_client/cli/trace/cost_trace.h"
#include "sweepstake/scene.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

inline constexpr uint32_t kBurstFrames = 8;
inline constexpr uint32_t kBlocksPerBurst = 3;
// Steps of the scene that come before the trace's first frame: structures settle, caches warm up.
inline constexpr uint32_t kTraceWarmupFrames = 20;

struct TracePlan {
  std::vector<std::string> arms;  // known ones
  uint32_t control_arm = 0;
  std::vector<uint64_t> frame_ns;  // roughly what a frame costs each arm
  uint32_t frame_count = 0;
  uint64_t order_seed = 0;  // of the order in which the arms take turns
};

// Roughly what a frame costs each arm: the minimum of a few frames. Steps the scene.
std::vector<uint64_t> ProbeArms(const std::vector<std::string>& arms, Scene& scene);

// Returns a trace that lacks only scene, seed, machine and repeat_count. kInternal: two arms found
// different numbers of pairs. REQUIRES: frame_count >= kBurstFrames; the scene stands at its start
// and its blocks hold kBurstFrames frames or more. `on_frame` hears the frames done, between
// blocks.
Result<CostTrace> RunTracePass(Scene& scene, const TracePlan& plan,
                               const std::function<void(uint32_t frames_done)>& on_frame);

}  // namespace sweepstake::cli
