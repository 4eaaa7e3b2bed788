#include "engine_client/adaptive/invalid_box_counter.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "sweepstake/adaptive_broad_phase.h"

namespace sweepstake {
namespace {

constexpr float kInfinite = std::numeric_limits<float>::infinity();
constexpr float kLargest = std::numeric_limits<float>::max();
constexpr Aabb kUnit = {{0, 0, 0}, {1, 1, 1}};
constexpr Aabb kPlane = {{-kInfinite, -kInfinite, -kInfinite}, {kInfinite, kInfinite, 0}};

TEST(InvalidBoxCounter, CountsInfiniteInvertedAndUndefinedBoxesButNoEmptyOnes) {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  constexpr float kSmallest = std::numeric_limits<float>::denorm_min();
  const std::pair<Aabb, uint32_t> boxes[] = {
      {kUnit, 0},
      {{{2, 2, 2}, {2, 2, 2}}, 0},
      {{{0.0F, 0, 0}, {-0.0F, 0, 0}}, 0},
      {{{-kLargest, -kLargest, -kLargest}, {kLargest, kLargest, kLargest}}, 0},
      {{{kInfinite, kInfinite, kInfinite}, {-kInfinite, -kInfinite, -kInfinite}}, 0},
      {{{1, 1, 1}, {0, 0, 0}}, 0},
      {kPlane, 1},
      {{{kInfinite, 0, 0}, {kInfinite, 1, 1}}, 1},
      {{{0, 0, 0}, {1, kInfinite, 1}}, 1},
      {{{0, 0, 0}, {1, 1, kNone}}, 1},
      {{{kNone, kNone, kNone}, {kNone, kNone, kNone}}, 1},
      {{{0, 1, 0}, {1, 0, 1}}, 1},
      {{{kSmallest, 0, 0}, {0, 1, 1}}, 1},
  };
  for (const auto& [box, count] : boxes) {
    InvalidBoxCounter counter;
    counter.CountAll({&box, 1});
    EXPECT_EQ(counter.count(), count) << box.min[0] << " to " << box.max[0];
    EXPECT_EQ(count == 0 && IsValid(box), IsValid(box)) << "a valid box never counts";
  }
}

TEST(InvalidBoxCounter, CountsAddedBoxesAtOnceAndChangedOnesInTurn) {
  constexpr size_t kCount = 80;
  constexpr size_t kFramesPerPass = kCount / InvalidBoxCounter::kMinBoxesPerFrame + 1;
  std::vector<Aabb> boxes(kCount, kUnit);
  boxes[7] = kPlane;
  InvalidBoxCounter counter;
  counter.CountAll(boxes);
  EXPECT_EQ(counter.count(), 1U);

  boxes.push_back(kPlane);
  counter.Follow(boxes);
  EXPECT_EQ(counter.count(), 2U);
  boxes.push_back(kUnit);
  counter.Follow(boxes);
  EXPECT_EQ(counter.count(), 2U);

  boxes[70] = kPlane;
  for (size_t frame = 0; frame < kFramesPerPass; ++frame) counter.Follow(boxes);
  EXPECT_EQ(counter.count(), 3U);
  boxes[7] = boxes[70] = kUnit;
  for (size_t frame = 0; frame < 2 * kFramesPerPass; ++frame) counter.Follow(boxes);
  EXPECT_EQ(counter.count(), 1U);
  boxes.resize(kCount);
  counter.Follow(boxes);
  EXPECT_EQ(counter.count(), 0U) << "the invalid box was removed";
}

TEST(InvalidBoxCounter, ReadsEveryBoxWithinAPassOfALargeScene) {
  std::vector<Aabb> boxes(100'000, kUnit);
  InvalidBoxCounter counter;
  counter.CountAll(boxes);
  boxes.front() = boxes[54'321] = boxes.back() = kPlane;
  for (size_t frame = 0; frame < InvalidBoxCounter::kFramesPerPass; ++frame) counter.Follow(boxes);
  EXPECT_EQ(counter.count(), 3U);
}

TEST(InvalidBoxCounter, NeverExceedsTheNumberOfBoxes) {
  const std::vector<Aabb> boxes(100, kPlane);
  InvalidBoxCounter counter;
  counter.CountAll(boxes);
  EXPECT_EQ(counter.count(), 100U);
  for (const size_t count : {99, 20, 3, 50, 0}) {
    counter.Follow(std::span(boxes).first(count));
    EXPECT_LE(counter.count(), count);
  }
  EXPECT_EQ(counter.count(), 0U);
}

TEST(InvalidBoxes, AreInTheSampleOfTheirFirstFrameWithEveryArm) {
  for (const std::string_view arm : BroadPhaseNames()) {
    const auto adaptive =
        std::move(*AdaptiveBroadPhase::Create({.arms = {std::string(arm)}}, nullptr));
    std::vector<Aabb> boxes(200, kUnit);
    boxes[150] = kPlane;
    for (uint32_t frame = 0; frame < 3; ++frame) {
      adaptive->BeginFrame();
      adaptive->FindPairs(boxes);
      adaptive->EndFrame({.frame_time_ns = 1});
      EXPECT_EQ(adaptive->last_sample().invalid_box_count, 1 + frame) << arm;
      boxes.push_back(kPlane);
    }
  }
}

}  // namespace
}  // namespace sweepstake
