// The shadow lane: a worker thread that measures the inactive arms on copies of the frames' boxes,
// so that their costs are known without running them in the game's frames, and that prepares the
// next arm before a switch, so that the switching frame takes no longer than others. Plain data:
// its options and its counters (AdaptiveBroadPhase::shadow_stats).
#pragma once

#include <cstdint>

namespace sweepstake {

// Values are stable: the C ABI has the same ones.
enum class ShadowMode : uint32_t {
  kOff = 0,
  kAuto = 1,  // on from the first Mode::kAi on: a game that goes manual then still learns
  kOn = 2,    // on in a game that has always been manual too
};

struct ShadowOptions {
  ShadowMode enabled = ShadowMode::kAuto;
  // The worker's time that visits and preparations take at most in the long run, over 0 to 1; less
  // where it would cost the game's searches more than 0.5 %, or would be more than half of what
  // they take. The first sweep is made at once.
  double duty_ratio = 0.15;
  // Maximum memory of the lane: half for copied boxes, half for structures. If the frames do not
  // fit, fewer are copied, and none if not even four fit (from 250,000 objects on with the
  // default). An arm whose structure and pairs outgrow their half is left in the midst of its
  // search. Up to 512 MiB and 1,000,000 objects, the lane ends what it does within 50 ms; beyond
  // that, a pair buffer that doubles is copied for longer (58 ms with 1 GiB). The lane takes at
  // most half of AdaptiveOptions::memory_budget_bytes, if that is less.
  uint64_t memory_cap_bytes = 64 * 1024 * 1024;
  // A visit of an arm ends when it reaches it, in the midst of a search too; > 0. In a game whose
  // frames are long, eight of them, twice, where that is more.
  uint64_t visit_cap_ns = 250'000'000;
  // Minimum time between sweeps.
  uint64_t sweep_interval_min_ns = 250'000'000;
};

// The lane's state and its reason. Values are stable: the C ABI has the same ones.
enum class ShadowState : uint32_t {
  kOff = 0,          // as the options say
  kOneArm = 1,       // off: there is nothing to compare
  kNoSpareCore = 2,  // at rest: the game leaves none of the cores that it may use; asked again
  kPaused = 3,       // kAuto in a game that has always been manual
  kRunning = 4,
  kTooBig = 5,  // the scene does not fit in the memory cap; tried again every second
};

// Counters since the session began; times in ns. Fields may be from slightly different moments.
struct ShadowStats {
  ShadowState state = ShadowState::kOff;
  uint64_t sweep_count = 0;
  uint64_t visit_count = 0;         // each to one arm
  uint64_t capped_visit_count = 0;  // of these, those that ended at a cap
  uint64_t busy_time_ns = 0;        // visits and preparations
  uint64_t memory_bytes = 0;        // copied boxes and structures, as of the latest frame it ran
  uint64_t copied_frame_count = 0;
  uint64_t copy_time_ns = 0;  // on the frame thread
  // By how much the frame thread's searches took longer beside the lane's work than between, times
  // that work: what the lane has cost the frame thread besides the copies.
  uint64_t slowdown_time_ns = 0;
  uint64_t warm_switch_count = 0;
  uint64_t cold_switch_count = 0;  // with or without a lane
};

}  // namespace sweepstake
