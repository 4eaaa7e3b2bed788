// Ends a trial (SwitchCommand::trial_limit_percent): compares the frames of the arm that is tried
// with those of late of the arm before, and says when to go back.
//
// A search may take the longest of late and, besides, what the limit grants of the longest frame of
// late, or kLeastNs, which nobody sees. Two frames in a row over it end the trial: an arm that is
// too expensive takes both, and what interrupts a game takes one. Of late are the latest
// kBlockFrames to 2 kBlockFrames frames of a run. Frames that rebuild and the first one of a trial,
// whose structure is new to the caches, count for nothing, since what they take is the switch's
// cost and not the arm's; nor do paused and loading ones, and those without a search. Plain values;
// not thread-safe.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>

#include "sweepstake/frame_sample.h"

namespace sweepstake {

class TrialGuard {
 public:
  static constexpr uint32_t kBlockFrames = 128;
  static constexpr uint64_t kLeastNs = 1'000'000;

  // How a trial ended.
  struct End {
    uint32_t arm_before = 0;
    uint32_t tried_arm = 0;
    uint64_t detection_time_ns = 0;  // over the limit, of the two frames' shorter one
    uint64_t frame_count = 0;        // of the trial
  };

  // A switch from `arm_before` is executed. If it is a trial, it lasts for `duration_ns` of frame
  // time. Without a frame to compare with there is none.
  void Begin(uint32_t arm_before, const SwitchCommand& command, uint64_t duration_ns) {
    trial_.reset();
    const Longest longest = Longest::Of(block_, earlier_block_);
    if (command.trial_limit_percent == 0 || longest.detection_ns == 0) return Forget();
    const uint64_t granted_percent = std::max(command.trial_limit_percent, 100U) - 100U;
    const uint64_t granted_ns = longest.frame_ns / 100 * granted_percent;
    trial_ = Trial{.arm_before = arm_before,
                   .limit_ns = longest.detection_ns + std::max(granted_ns, kLeastNs),
                   .left_ns = duration_ns};
  }

  // Ends a trial that the game takes over.
  void Cancel() {
    if (std::exchange(trial_, std::nullopt)) Forget();
  }

  // Takes a finished frame. Returns the end of the trial if it and the one before are over its
  // limit; then the next frame is to run the arm before.
  std::optional<End> OnFrame(const FrameSample& sample) {
    if ((sample.flags & (kFramePaused | kFrameLoading)) != 0) return std::nullopt;
    if (sample.detection_time_ns == 0) return std::nullopt;
    const bool is_first = trial_ && trial_->frame_count++ == 0;
    if (is_first || (sample.flags & kFrameRebuild) != 0) return std::nullopt;
    if (!trial_) {
      Note({.detection_ns = sample.detection_time_ns, .frame_ns = sample.frame_time_ns});
      return std::nullopt;
    }
    const uint64_t over_ns =
        sample.detection_time_ns > trial_->limit_ns ? sample.detection_time_ns : 0;
    const uint64_t both_ns = std::min(std::exchange(trial_->over_ns, over_ns), over_ns);
    if (both_ns > 0) {
      const Trial ended = *std::exchange(trial_, std::nullopt);
      return End{.arm_before = ended.arm_before,
                 .tried_arm = sample.arm,
                 .detection_time_ns = both_ns,
                 .frame_count = ended.frame_count};
    }
    trial_->left_ns -= std::min(trial_->left_ns, sample.frame_time_ns);
    if (trial_->left_ns == 0) Cancel();
    return std::nullopt;
  }

 private:
  struct Trial {
    uint32_t arm_before = 0;
    uint64_t limit_ns = 0;
    uint64_t left_ns = 0;
    uint64_t frame_count = 0;
    uint64_t over_ns = 0;  // detection of the frame before, if it was over the limit
  };
  struct Longest {
    uint64_t detection_ns = 0;
    uint64_t frame_ns = 0;

    static Longest Of(const Longest& a, const Longest& b) {
      return {std::max(a.detection_ns, b.detection_ns), std::max(a.frame_ns, b.frame_ns)};
    }
  };

  void Note(const Longest& frame) {
    if (block_frame_count_++ == kBlockFrames) {
      earlier_block_ = std::exchange(block_, Longest{});
      block_frame_count_ = 1;
    }
    block_ = Longest::Of(block_, frame);
  }

  // Another arm runs from now on.
  void Forget() {
    block_ = earlier_block_ = Longest{};
    block_frame_count_ = 0;
  }

  std::optional<Trial> trial_;
  Longest block_;  // the present one
  Longest earlier_block_;
  uint64_t block_frame_count_ = 0;
};

}  // namespace sweepstake
