// What a session ran between two reports, for the history of its scene, its build and itself.
//
// A UseMeter is used on the decision loop only. Its memory is bounded by the number of arms and by
// LogHistogram::kMaxBuckets.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine_client/decider/policy/regime_report.h"
#include "engine_client/include/sweepstake/frame_sample.h"
#include "server/sessions/common/log_histogram.h"

namespace sweepstake::sessions {

struct SessionUse {
  int64_t unix_start_ms = 0;  // when the first frames arrived, by the wall clock, since 1970
  int64_t unix_end_ms = 0;
  // The costs of all frames that were neither paused nor loading.
  FrameHistograms frames = {};
  std::vector<uint64_t> active_frame_counts = {};  // those in which each arm ran; one per arm
  // The increase of decision::SessionTally::total.
  decision::RegimeUse measured = {};
  uint32_t initial_arm = 0;   // index of the arm with which the game begins
  uint64_t switch_count = 0;  // executed switches
  bool is_first = false;      // the session's first report
};

class UseMeter {
 public:
  // The longest time between two reports, and the finest step of the history.
  static constexpr int64_t kStepMs = 15'000;

  explicit UseMeter(size_t arm_count) : arm_count_(arm_count) { Begin(); }

  void AddFrames(std::span<const FrameSample> frames, int64_t unix_now_ms);
  void AddSwitch() { ++use_.switch_count; }
  // Returns whether frames were added in an earlier step of the wall clock.
  bool IsDue(int64_t unix_now_ms) const {
    return !is_empty() && unix_now_ms / kStepMs != use_.unix_start_ms / kStepMs;
  }
  bool is_empty() const { return use_.frames.empty(); }
  // Returns what was added since the previous call. `total` is SessionTally::total, and
  // `initial_arm` the index of the arm with which the game begins.
  SessionUse Take(const decision::RegimeUse& total, uint32_t initial_arm, int64_t unix_now_ms);

 private:
  void Begin() { use_ = {.active_frame_counts = std::vector<uint64_t>(arm_count_)}; }

  const size_t arm_count_;
  SessionUse use_;
  bool is_first_ = true;
  decision::RegimeUse reported_;  // `total` at the previous report
};

}  // namespace sweepstake::sessions
