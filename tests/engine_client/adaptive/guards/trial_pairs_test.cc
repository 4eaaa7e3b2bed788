// A game gets all pairs in a trial, wherever the search of the tried arm is stopped.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine_client/adaptive/shadow_schedule.h"
#include "engine_client/scene/box_scenes.h"
#include "sweepstake/adaptive_broad_phase.h"
#include "sweepstake/executor.h"
#include "tests/support/pair_oracle.h"
#include "tests/support/recording_sink.h"

namespace sweepstake {
namespace {

using test_support::RecordingSink;

constexpr uint64_t kDenseFrameNs = 10'000'000;
// Nearly all of these boxes overlap, so that each arm's search polls several times.
constexpr uint32_t kObjects = 1'300;
// No trial frame of an arm here reads the clock as often.
constexpr uint64_t kMaxReadings = 200;

// A clock that goes on by 1 ns per reading, and at one of them by a second. During a trial, a poll
// is a reading.
class JumpingClock final : public Clock {
 public:
  uint64_t NowNs() noexcept override {
    const uint64_t passed_ns = ++readings_ == jump_at_ ? 1'000'000'000 : 1;
    return now_ns_ += passed_ns;
  }
  // Jumps at the `count`-th reading from now on.
  void JumpAfter(uint64_t count) { jump_at_ = readings_ + count; }

 private:
  std::atomic<uint64_t> readings_{0};
  std::atomic<uint64_t> now_ns_{1};
  std::atomic<uint64_t> jump_at_{std::numeric_limits<uint64_t>::max()};
};

std::vector<std::vector<Aabb>> DenseFrames() {
  std::vector<std::vector<Aabb>> frames;
  const auto scene = MakeDegenerateScene("all-coincident", kObjects, 1);
  for (int frame = 0; frame < 9; ++frame) {
    const auto boxes = scene->aabbs();
    frames.emplace_back(boxes.begin(), boxes.end());
    // Some boxes leave the crowd, others come back, and the number of boxes changes.
    for (size_t i = static_cast<size_t>(frame); i < frames.back().size(); i += 5)
      frames.back()[i].min[0] += 100, frames.back()[i].max[0] += 100;
    frames.back().resize(kObjects - static_cast<size_t>(frame % 3));
  }
  return frames;
}

// A game in which `tried` is tried and stopped at one poll of a frame.
class TrialGame {
 public:
  TrialGame(std::string_view tried, Executor* executor)
      : adaptive_(
            std::move(*AdaptiveBroadPhase::Create({.arms = {Former(tried), std::string(tried)},
                                                   .settling_ns = 1'000 * kDenseFrameNs,
                                                   .executor = executor,
                                                   .shadow = {.enabled = ShadowMode::kOff},
                                                   .sorted_pairs = true},
                                                  &sink_, clock_))) {}

  // Plays the frames up to `number` + 1. The clock jumps at this reading of frame `number`. Returns
  // whether the search was stopped.
  bool Play(size_t number, uint64_t reading) {
    static const std::vector<std::vector<Aabb>> frames = DenseFrames();
    static const std::vector<std::vector<OverlapPair>> expected = ExpectedOf(frames);
    bool is_stopped = false;
    for (size_t i = 0; i < std::min(frames.size(), number + 2); ++i) {
      if (i == 3) adaptive_->mailbox().Post({.arm = 1, .trial_limit_percent = 120});
      if (i == number) clock_.JumpAfter(reading);
      adaptive_->BeginFrame();
      const auto pairs = adaptive_->FindPairs(frames[i]);
      EXPECT_TRUE(std::ranges::equal(pairs, expected[i]))
          << "frame " << i << ", reading " << reading;
      adaptive_->EndFrame({.frame_time_ns = kDenseFrameNs});
      if (i == number) is_stopped = adaptive_->last_sample().arm == 0;
    }
    return is_stopped;
  }

 private:
  static std::string Former(std::string_view tried) { return tried == "SAP" ? "KDTree" : "SAP"; }
  static std::vector<std::vector<OverlapPair>> ExpectedOf(
      const std::vector<std::vector<Aabb>>& frames) {
    std::vector<std::vector<OverlapPair>> all;
    for (const auto& boxes : frames) all.push_back(test_support::ScalarPairs(boxes));
    return all;
  }

  RecordingSink sink_;
  JumpingClock clock_;
  std::unique_ptr<AdaptiveBroadPhase> adaptive_;
};

class TriedArm : public ::testing::TestWithParam<std::string_view> {
 protected:
  // Stops the trial at several readings of the clock in turn. Returns the number of times that a
  // search was stopped. The first frames of the trial have no limit.
  int StopEverywhere(size_t frame) {
    int stops = 0;
    for (uint64_t reading = 2; reading < kMaxReadings; reading += 1 + reading / 3) {
      // If this is false, the jump came after the search.
      if (!TrialGame(GetParam(), nullptr).Play(frame, reading)) break;
      ++stops;
    }
    return stops;
  }
};

TEST_P(TriedArm, AnswersWithAllPairsWhereverItsUpdateOrSearchIsStopped) {
  EXPECT_GE(StopEverywhere(/*frame=*/7), 2);
}

// The threads poll in any order, so that not every jump stops the search.
TEST_P(TriedArm, AnswersWithAllPairsIfThreadsAreStopped) {
  const auto pool = MakeThreadPool(2);
  int stops = 0;
  for (const uint64_t reading : {2U, 3U, 4U, 6U})
    stops += TrialGame(GetParam(), pool.get()).Play(/*number=*/7, reading) ? 1 : 0;
  EXPECT_GE(stops, 1);
}

INSTANTIATE_TEST_SUITE_P(EveryArm, TriedArm,
                         ::testing::Values("BruteForce", "Grid", "SAP", "AxisSweep", "DBVT",
                                           "Tracy", "KDTree"),
                         [](const auto& arm) { return std::string(arm.param); });

}  // namespace
}  // namespace sweepstake
