// The shadow lane: a worker thread that measures the arms that are not active on copies of the
// frames' boxes, so that they become known without being shown to the player, and that prepares the
// next arm before a switch, so that the switching frame is an ordinary one. Plain data: its options
// and what it has done (AdaptiveBroadPhase::shadow_stats).
#pragma once

#include <cstdint>

namespace sweepstake {

// Values are stable: the C ABI has the same ones.
enum class ShadowMode : uint32_t {
  kOff = 0,
  kAuto = 1,  // on in Mode::kAi
  kOn = 2,    // on in Mode::kManual too
};

struct ShadowOptions {
  ShadowMode enabled = ShadowMode::kAuto;
  // Share of the worker's time that visits and preparations take in the long run; over 0, at most
  // 1. The first sweep over all arms is made at once.
  double duty_ratio = 0.15;
  // Most memory of the lane: half for copied boxes, half for structures. Fewer frames are copied
  // where they do not fit, none where not even four do: 250,000 objects with the default.
  uint64_t memory_cap_bytes = 64 * 1024 * 1024;
  // A visit of an arm ends with the frame that reaches it; > 0.
  uint64_t visit_cap_ns = 250'000'000;
  // Least time from sweep to sweep.
  uint64_t sweep_interval_min_ns = 250'000'000;
};

// Why the lane does what it does. Values are stable: the C ABI has the same ones.
enum class ShadowState : uint32_t {
  kOff = 0,          // as asked for
  kOneArm = 1,       // off: there is nothing to compare
  kNoSpareCore = 2,  // off: the machine has one core, or the executor uses all
  kPaused = 3,       // in manual mode
  kRunning = 4,
  kTooBig = 5,  // the scene does not fit in the memory cap; looked at again every second
};

// Since the session began. Times in ns. Values of one moment, or of moments close together.
struct ShadowStats {
  ShadowState state = ShadowState::kOff;
  uint64_t sweep_count = 0;
  uint64_t visit_count = 0;         // of one arm each
  uint64_t capped_visit_count = 0;  // of these, those that ended at a cap
  uint64_t busy_time_ns = 0;        // visits and preparations
  uint64_t memory_bytes = 0;        // copied boxes and structures, now
  uint64_t copied_frame_count = 0;
  uint64_t copy_time_ns = 0;  // on the frame thread
  uint64_t warm_switch_count = 0;
  uint64_t cold_switch_count = 0;  // with or without a lane
};

}  // namespace sweepstake
