// Decides when a trial ends early (SwitchCommand::trial_limit_percent). It compares frames of the
// tried arm with recent frames of the previous arm.
//
// "Recent" are the last 128 to 256 frames of the previous arm (kBlockFrames to 2 kBlockFrames), or
// all of them if there are fewer. Two rules end a trial:
// - Limit: two searches in a row exceed the longest recent search by more than the allowance. The
//   allowance is (trial_limit_percent − 100) percent of the longest recent frame, but at least
//   kLeastNs. An interruption of the game lengthens only one frame; an arm that is too expensive
//   lengthens both.
// - Budget: all searches of the trial together take longer than the recent mean for each, plus
//   1/kBudgetShare of the trial's duration. One search uses up at most 1/kFrameShare of this
//   budget.
//
// These frames are special:
// - The first 1 + kShadowWarmUpFrames frames with a search are not compared, because the extra time
//   of a new structure belongs to the switch cost. They do not count towards the trial's duration
//   either.
// - Frames that rebuild, and frames without a search, are not compared but count towards the
//   duration.
// - Paused, loading and suspended frames are ignored.
//
// The searches of one frame count as one. Plain values; not thread-safe.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>

#include "engine_client/adaptive/shadow_schedule.h"
#include "sweepstake/frame_sample.h"

namespace sweepstake {

class TrialGuard {
 public:
  static constexpr uint32_t kBlockFrames = 128;
  static constexpr uint64_t kLeastNs = 1'000'000;
  static constexpr uint64_t kBudgetShare = 40;
  static constexpr uint64_t kFrameShare = 8;
  // After an ended trial of at most this many frames, the previous arm continues with its old
  // structure, because objects have not moved far. After a longer trial its structure is rebuilt.
  static constexpr uint64_t kMaxKeptFrames = 8;

  // The measurements that ended a trial.
  struct End {
    uint32_t arm_before = 0;
    uint32_t tried_arm = 0;
    uint64_t detection_time_ns = 0;  // the time that broke a rule (SwitchOutcome)
    uint64_t frame_count = 0;        // frames of the trial that had a search
  };

  // Call when a switch from `arm_before` is executed. Begins a trial of `duration_ns` of frame time
  // if the command requires a trial and at least one frame of the previous arm was recorded.
  void Begin(uint32_t arm_before, const SwitchCommand& command, uint64_t duration_ns) {
    trial_.reset();
    const Frames late = Frames::Of(block_, earlier_block_);
    block_ = earlier_block_ = Frames{};
    if (command.trial_limit_percent == 0 || late.count == 0) return;
    const uint64_t granted_percent = std::max(command.trial_limit_percent, 100U) - 100U;
    const uint64_t granted_ns = late.longest_frame_ns / 100 * granted_percent;
    trial_ = Trial{.arm_before = arm_before,
                   .before = late,
                   .limit_ns = late.longest_detection_ns + std::max(granted_ns, kLeastNs),
                   .budget_ns = duration_ns / kBudgetShare,
                   .left_ns = duration_ns};
  }

  // Ends the trial without a result, for example because the game has chosen an arm.
  void Cancel() { trial_.reset(); }

  // Adds a finished frame. If a rule above is broken, ends the trial and returns its measurements;
  // the next frame must then run the previous arm.
  std::optional<End> OnFrame(const FrameSample& sample) {
    if ((sample.flags & kFrameWithoutCost) != 0) return std::nullopt;
    const bool searches = sample.detection_time_ns > 0;
    if (trial_ && searches && trial_->frame_count++ <= kShadowWarmUpFrames) return std::nullopt;
    const bool counts = searches && (sample.flags & kFrameRebuild) == 0;
    const std::optional<End> end = counts ? Compare(sample) : std::nullopt;
    if (trial_) trial_->left_ns -= std::min(trial_->left_ns, sample.frame_time_ns);
    if (end || (trial_ && trial_->left_ns == 0)) trial_.reset();
    return end;
  }

 private:
  // Sums and maxima over the compared frames of one arm.
  struct Frames {
    uint64_t count = 0;
    uint64_t detection_ns = 0;  // total of all searches
    uint64_t longest_detection_ns = 0;
    uint64_t longest_frame_ns = 0;

    uint64_t mean_ns() const { return detection_ns / std::max<uint64_t>(count, 1); }
    static Frames Of(const Frames& a, const Frames& b) {
      return {.count = a.count + b.count,
              .detection_ns = a.detection_ns + b.detection_ns,
              .longest_detection_ns = std::max(a.longest_detection_ns, b.longest_detection_ns),
              .longest_frame_ns = std::max(a.longest_frame_ns, b.longest_frame_ns)};
    }
  };
  struct Trial {
    uint32_t arm_before = 0;
    Frames before;  // recent frames of the previous arm
    uint64_t limit_ns = 0;
    uint64_t budget_ns = 0;
    uint64_t left_ns = 0;
    uint64_t frame_count = 0;
    uint64_t judged_count = 0;
    uint64_t judged_ns = 0;  // sum of the compared searches, each capped by the budget rule
    uint64_t over_ns = 0;    // previous frame's detection time if over the limit, else 0

    // Adds a search. Returns the detection time that broke a rule, or 0 if no rule is broken.
    uint64_t Judge(uint64_t detection_ns) {
      const uint64_t before_ns =
          std::exchange(over_ns, detection_ns > limit_ns ? detection_ns : uint64_t{0});
      if (const uint64_t both_ns = std::min(before_ns, over_ns); both_ns > 0) return both_ns;
      judged_ns += std::min(detection_ns, before.mean_ns() + budget_ns / kFrameShare);
      ++judged_count;
      const bool is_over = judged_ns > judged_count * before.mean_ns() + budget_ns;
      return is_over ? judged_ns / judged_count : 0;
    }
  };

  std::optional<End> Compare(const FrameSample& sample) {
    Note(sample);
    const uint64_t excessive_ns = trial_ ? trial_->Judge(sample.detection_time_ns) : 0;
    if (excessive_ns == 0) return std::nullopt;
    return End{.arm_before = trial_->arm_before,
               .tried_arm = sample.arm,
               .detection_time_ns = excessive_ns,
               .frame_count = trial_->frame_count};
  }

  void Note(const FrameSample& sample) {
    if (block_.count >= kBlockFrames) earlier_block_ = std::exchange(block_, Frames{});
    block_ = Frames::Of(block_, {.count = 1,
                                 .detection_ns = sample.detection_time_ns,
                                 .longest_detection_ns = sample.detection_time_ns,
                                 .longest_frame_ns = sample.frame_time_ns});
  }

  std::optional<Trial> trial_;
  Frames block_;  // the current block of up to kBlockFrames frames
  Frames earlier_block_;
};

}  // namespace sweepstake
