#include "tests/laboratory/game/frame_block.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "engine_client/cli/game/scene_choice.h"

namespace sweepstake::cli {
namespace {

TEST(FrameBlock, KeepsTheBoxesOfEachStep) {
  const auto scene = std::move(*OpenScene({"spawning", 300, 4}));
  const auto twin = std::move(*OpenScene({"spawning", 300, 4}));
  FrameBlock block;
  for (int refill = 0; refill < 3; ++refill) {
    block.Fill(*scene, 7);
    ASSERT_EQ(block.step_count(), 7U);
    for (size_t step = 0; step < 7; ++step) {
      twin->Step();
      EXPECT_TRUE(std::ranges::equal(block.BoxesOf(step), twin->aabbs())) << refill << ", " << step;
    }
  }
}

TEST(FrameBlock, HoldsABoundedNumberOfSteps) {
  const auto scene = std::move(*OpenScene({"suite-b", 10, 1}));
  FrameBlock block;
  block.Fill(*scene, 1'000'000);
  EXPECT_EQ(block.step_count(), kMaxStepsInBlock);
  EXPECT_EQ(scene->frame_index(), kMaxStepsInBlock);
}

TEST(FrameBlock, StopsOnceItsMemoryIsFull) {
  const auto scene = std::move(*OpenScene({"suite-b", 400'000, 1}));
  FrameBlock block;
  block.Fill(*scene, 20);
  const size_t bytes = 400'000 * sizeof(Aabb);
  EXPECT_EQ(block.step_count(), (kMaxBlockBytes + bytes - 1) / bytes);
}

TEST(FrameBlock, OfAnEmptySceneHasEmptySteps) {
  const auto scene = std::move(*OpenScene({"empty", 10, 1}));
  FrameBlock block;
  block.Fill(*scene, 3);
  ASSERT_EQ(block.step_count(), 3U);
  EXPECT_TRUE(block.BoxesOf(0).empty());
  EXPECT_TRUE(block.BoxesOf(2).empty());
}

}  // namespace
}  // namespace sweepstake::cli
