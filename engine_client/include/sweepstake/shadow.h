// The shadow lane: a worker thread that measures the inactive arms on copies of the frames' boxes,
// so that their costs are known without running them in the game's frames. It also prepares the
// next arm before a switch, so that the switching frame takes no longer than others. Plain data:
// the lane's options and its counters (AdaptiveBroadPhase::shadow_stats).
#pragma once

#include <cstdint>

namespace sweepstake {

// Values are stable: the C ABI has the same ones.
enum class ShadowMode : uint32_t {
  kOff = 0,
  // Runs from the first Mode::kAi on, also while the mode is then kManual. Rests with a policy that
  // does not learn from it, such as `paper`, whose switches are then cold.
  kAuto = 1,
  kOn = 2,  // runs also in a game that has always been manual, and with each policy
};

struct ShadowOptions {
  ShadowMode enabled = ShadowMode::kAuto;
  // The maximum share of one core that visits and preparations take in the long run, over 0 to 1.
  // It is less if the lane would slow the game's searches by more than 0.5 %, or would take more
  // than half of their time. The first sweep is made at once.
  double duty_ratio = 0.15;
  // Maximum memory of the lane: half for copied boxes, half for structures. If the frames do not
  // fit, fewer are copied, and none if less than four fit (from 250,000 objects on with the
  // default). The search of an arm whose structure and pairs exceed their half is stopped. The lane
  // takes at most half of AdaptiveOptions::memory_budget_bytes, if that is less.
  //
  // Up to 512 MiB and 1,000,000 objects, a stop takes at most 50 ms. Beyond that, copying a pair
  // buffer that doubles takes longer (58 ms with 1 GiB).
  uint64_t memory_cap_bytes = 64 * 1024 * 1024;
  // The time cap of a visit, which stops even a search. Must be > 0. In a game with long frames it
  // is twice the time of eight frames, if that is longer.
  uint64_t visit_cap_ns = 250'000'000;
  // Minimum time between sweeps.
  uint64_t sweep_interval_min_ns = 250'000'000;
};

// The lane's state and its reason. Values are stable: the C ABI has the same ones.
enum class ShadowState : uint32_t {
  kOff = 0,          // the options disable the lane
  kOneArm = 1,       // off: there is only one arm
  kNoSpareCore = 2,  // resting: the game uses all cores; checked again every second
  kPaused = 3,       // kAuto rests: see ShadowMode
  kRunning = 4,
  kTooBig = 5,  // the scene does not fit in the memory cap; tried again every second
};

// Counters since the session began; times in ns. Fields may be from slightly different moments.
struct ShadowStats {
  ShadowState state = ShadowState::kOff;
  uint64_t sweep_count = 0;
  uint64_t visit_count = 0;         // measurements of one arm each
  uint64_t capped_visit_count = 0;  // visits that ended at a cap
  uint64_t busy_time_ns = 0;        // time of visits and preparations
  uint64_t memory_bytes = 0;        // copied boxes and structures, after the lane's latest frame
  uint64_t copied_frame_count = 0;
  uint64_t copy_time_ns = 0;  // time of copying boxes on the frame thread
  // The estimated cost of the lane to the frame thread besides the copies: the measured slowdown of
  // searches during the lane's work, times the duration of that work.
  uint64_t slowdown_time_ns = 0;
  uint64_t warm_switch_count = 0;
  uint64_t cold_switch_count = 0;  // also counts switches without a lane
};

}  // namespace sweepstake
