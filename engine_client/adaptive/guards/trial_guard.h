// Decides how long a search may take in a trial, and when the trial ends early
// (SwitchCommand::trial_limit_percent). It compares the tried arm with recent frames of the
// previous arm.
//
// "Recent" are the last 128 to 256 frames of the previous arm (kBlockFrames to 2 kBlockFrames), or
// all of them if there are fewer. Three rules end a trial:
// - Stop: the caller stops a search at the limit (TrialStop) and answers the frame from the
//   previous arm's structure. The limit is the reference plus a margin. The reference is the
//   longest recent search but one: the previous arm's own long searches count, one interruption of
//   the game does not. The margin is (trial_limit_percent − 100) percent of the reference, but at
//   least 1/kFrameShare of the mean recent frame. The minimum is for short searches: a cold
//   cache makes them much longer. The time that the trial's earlier searches saved, compared with
//   the recent mean, is added to the limit, up to one further margin. A cheaper arm may thus
//   rebuild its structure.
// - Limit: a search that could not be stopped took longer than the limit. The next frame then runs
//   the previous arm.
// - Budget: all searches of the trial together take longer than the recent mean for each, plus
//   1/kBudgetShare of the trial's duration.
//
// The end of a trial has the mean of its searches, not the longest one. A periodic rebuild would
// otherwise count as the cost of every search.
//
// These frames are special:
// - In the first 1 + kShadowWarmUpFrames frames with a search, the structure is new. Only the stop
//   ends the trial there. Without a prepared structure the first search builds it, so each of these
//   searches may take kColdFactor times the reference. (With a factor of 3, games without a lane
//   stopped the builds of cheaper arms and stayed on slow ones.) These frames do not count towards
//   the trial's duration.
// - Frames that rebuild, and frames without a search, are not compared but count towards the
//   duration.
// - Frames with a flag of kFrameWithoutCost are ignored.
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
  static constexpr uint64_t kFrameShare = 20;
  static constexpr uint64_t kBudgetShare = 40;
  static constexpr uint64_t kColdFactor = 5;

  // The measurements of a trial that ended early.
  struct End {
    uint32_t arm_before = 0;
    uint32_t tried_arm = 0;
    uint64_t detection_time_ns = 0;  // mean of the trial's searches (SwitchOutcome)
  };

  // Call when a switch from `arm_before` is executed. Begins a trial of `duration_ns` of frame time
  // if the command requires a trial and at least one frame of the previous arm was recorded.
  // `is_built`: the structure of the new arm is prepared.
  void Begin(uint32_t arm_before, const SwitchCommand& command, uint64_t duration_ns,
             bool is_built) {
    trial_.reset();
    const Frames late = Frames::Of(block_, earlier_block_);
    block_ = earlier_block_ = Frames{};
    if (command.trial_limit_percent == 0 || late.count == 0) return;
    const uint64_t granted_percent = std::max(command.trial_limit_percent, 100U) - 100U;
    const uint64_t granted_ns = late.reference_ns() / 100 * granted_percent;
    const uint64_t margin_ns = std::max(granted_ns, late.mean_frame_ns() / kFrameShare);
    trial_ = Trial{.arm = command.arm,
                   .arm_before = arm_before,
                   .before = late,
                   .margin_ns = margin_ns,
                   .is_built = is_built,
                   .budget_ns = duration_ns / kBudgetShare,
                   .left_ns = duration_ns};
  }

  // Ends the trial without a result, for example because the game has chosen an arm.
  void Cancel() { trial_.reset(); }

  // Returns the time that all searches of the next frame may take. Absent: there is no trial.
  std::optional<uint64_t> limit_ns() const {
    if (!trial_) return std::nullopt;
    const bool is_cold = trial_->is_new() && !trial_->is_built;
    if (!is_cold) return trial_->limit_ns();
    return std::max(trial_->limit_ns(), kColdFactor * trial_->before.reference_ns());
  }

  // Ends the trial because a search was stopped after `detection_ns`. The frame must not be passed
  // to OnFrame. The search counts with at most the limit of a prepared structure, which is what a
  // stop proves: it may have been suspended, or have built the structure. REQUIRES: limit_ns() is
  // present.
  End Stop(uint64_t detection_ns) {
    trial_->Add(std::min(detection_ns, trial_->limit_ns()));
    const End end = EndOfTrial();
    trial_.reset();
    return end;
  }

  // Adds a finished frame, without the time `waited_ns` in which its searches waited for the core.
  // If a rule above is broken, ends the trial and returns its measurements; the next frame must
  // then run the previous arm.
  std::optional<End> OnFrame(const FrameSample& sample, uint64_t waited_ns = 0) {
    if ((sample.flags & kFrameWithoutCost) != 0) return std::nullopt;
    const bool searches = sample.detection_time_ns > 0;
    if (trial_ && searches && trial_->is_new()) {
      ++trial_->frame_count;
      return std::nullopt;
    }
    const bool counts = searches && (sample.flags & kFrameRebuild) == 0;
    const std::optional<End> end = counts ? Compare(sample, waited_ns) : std::nullopt;
    if (trial_) trial_->left_ns -= std::min(trial_->left_ns, sample.frame_time_ns);
    if (end || (trial_ && trial_->left_ns == 0)) trial_.reset();
    return end;
  }

 private:
  // Sums and the two longest searches of the compared frames of one arm.
  struct Frames {
    uint64_t count = 0;
    uint64_t detection_ns = 0;  // total of all searches
    uint64_t frame_ns = 0;      // total of all frames
    uint64_t longest_ns = 0;    // the longest search
    uint64_t second_ns = 0;     // the longest of the other searches

    uint64_t mean_ns() const { return detection_ns / std::max<uint64_t>(count, 1); }
    uint64_t mean_frame_ns() const { return frame_ns / std::max<uint64_t>(count, 1); }
    uint64_t reference_ns() const { return count > 1 ? second_ns : longest_ns; }
    static Frames Of(const Frames& a, const Frames& b) {
      return {
          .count = a.count + b.count,
          .detection_ns = a.detection_ns + b.detection_ns,
          .frame_ns = a.frame_ns + b.frame_ns,
          .longest_ns = std::max(a.longest_ns, b.longest_ns),
          .second_ns = std::max({std::min(a.longest_ns, b.longest_ns), a.second_ns, b.second_ns})};
    }
  };
  struct Trial {
    uint32_t arm = 0;
    uint32_t arm_before = 0;
    Frames before;  // recent frames of the previous arm
    uint64_t margin_ns = 0;
    bool is_built = false;  // the structure was prepared
    uint64_t budget_ns = 0;
    uint64_t left_ns = 0;
    uint64_t frame_count = 0;  // frames with a search while is_new()
    uint64_t judged_count = 0;
    uint64_t judged_ns = 0;  // sum of the compared searches

    bool is_new() const { return frame_count <= kShadowWarmUpFrames; }
    // The time that as many searches of the previous arm take.
    uint64_t usual_ns() const { return judged_count * before.mean_ns(); }
    uint64_t limit_ns() const {
      const uint64_t saved_ns = usual_ns() - std::min(judged_ns, usual_ns());
      return before.reference_ns() + margin_ns + std::min(saved_ns, margin_ns);
    }
    void Add(uint64_t detection_ns) {
      judged_ns += detection_ns;
      ++judged_count;
    }
    // Adds a search. Returns whether a rule is broken.
    bool Judge(uint64_t detection_ns) {
      const bool is_long = detection_ns > limit_ns();
      Add(detection_ns);
      return is_long || judged_ns > usual_ns() + budget_ns;
    }
  };

  End EndOfTrial() const {
    return {.arm_before = trial_->arm_before,
            .tried_arm = trial_->arm,
            .detection_time_ns = trial_->judged_ns / trial_->judged_count};
  }

  std::optional<End> Compare(const FrameSample& sample, uint64_t waited_ns) {
    Note(sample);
    const uint64_t computed_ns =
        sample.detection_time_ns - std::min(waited_ns, sample.detection_time_ns);
    if (!trial_ || !trial_->Judge(computed_ns)) return std::nullopt;
    return EndOfTrial();
  }

  void Note(const FrameSample& sample) {
    if (block_.count >= kBlockFrames) earlier_block_ = std::exchange(block_, Frames{});
    block_ = Frames::Of(block_, {.count = 1,
                                 .detection_ns = sample.detection_time_ns,
                                 .frame_ns = sample.frame_time_ns,
                                 .longest_ns = sample.detection_time_ns});
  }

  std::optional<Trial> trial_;
  Frames block_;  // the current block of up to kBlockFrames frames
  Frames earlier_block_;
};

}  // namespace sweepstake
