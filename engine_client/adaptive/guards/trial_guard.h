// Ends a trial (SwitchCommand::trial_limit_percent): compares the frames of the arm that is tried
// with the longest one of late of the arm before, and says when to go back.
//
// The longest of late is that of the latest kBlockFrames to 2 kBlockFrames frames of a run. Frames
// that rebuild and the first one of a trial, whose structure is new to the caches, count for
// nothing, since what they take is the switch's cost and not the arm's; nor do paused and loading
// ones, and those without a search. Plain values; not thread-safe.
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

  // How a trial ended.
  struct End {
    uint32_t arm_before = 0;
    uint32_t tried_arm = 0;
    uint64_t detection_time_ns = 0;  // over the limit
    uint64_t frame_count = 0;        // of the trial
  };

  // A switch from `arm_before` is executed. If it is a trial, it lasts for `duration_ns` of frame
  // time. Without a frame to compare with there is none.
  void Begin(uint32_t arm_before, const SwitchCommand& command, uint64_t duration_ns) {
    trial_.reset();
    const uint64_t longest_ns = std::max(longest_ns_, earlier_longest_ns_);
    if (command.trial_limit_percent == 0 || longest_ns == 0) return Forget();
    trial_ = Trial{.arm_before = arm_before,
                   .limit_ns = longest_ns * command.trial_limit_percent / 100,
                   .left_ns = duration_ns};
  }

  // Ends a trial that the game takes over.
  void Cancel() {
    if (std::exchange(trial_, std::nullopt)) Forget();
  }

  // Takes a finished frame. Returns the end of the trial if the frame is over its limit; then the
  // next frame is to run the arm before.
  std::optional<End> OnFrame(const FrameSample& sample) {
    if ((sample.flags & (kFramePaused | kFrameLoading)) != 0) return std::nullopt;
    if (sample.detection_time_ns == 0) return std::nullopt;
    const bool is_first = trial_ && trial_->frame_count++ == 0;
    if (is_first || (sample.flags & kFrameRebuild) != 0) return std::nullopt;
    if (!trial_) {
      Note(sample.detection_time_ns);
      return std::nullopt;
    }
    if (sample.detection_time_ns > trial_->limit_ns) {
      const Trial ended = *std::exchange(trial_, std::nullopt);
      return End{.arm_before = ended.arm_before,
                 .tried_arm = sample.arm,
                 .detection_time_ns = sample.detection_time_ns,
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
  };

  void Note(uint64_t detection_ns) {
    if (block_frame_count_++ == kBlockFrames) {
      earlier_longest_ns_ = std::exchange(longest_ns_, 0);
      block_frame_count_ = 1;
    }
    longest_ns_ = std::max(longest_ns_, detection_ns);
  }

  // Another arm runs from now on.
  void Forget() { longest_ns_ = earlier_longest_ns_ = block_frame_count_ = 0; }

  std::optional<Trial> trial_;
  uint64_t longest_ns_ = 0;  // of the present block
  uint64_t earlier_longest_ns_ = 0;
  uint64_t block_frame_count_ = 0;
};

}  // namespace sweepstake
