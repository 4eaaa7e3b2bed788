#include "engine_client/broad_phase/common/coordinate_range.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "engine_client/scene/box_scenes.h"

namespace sweepstake {
namespace {

TEST(CoordinateRange, CoversMostBoxesDespiteOutliers) {
  const BoxScene scene("brownian", 1000, 1);
  std::vector<Aabb> boxes(scene.boxes().begin(), scene.boxes().end());
  boxes[0] = {{1e30F, 1e30F, 1e30F}, {2e30F, 2e30F, 2e30F}};
  const CoordinateRange range = CoordinateRange::Sample(boxes);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_LE(range.low[axis], 1);
    EXPECT_GE(range.high[axis], 9);
    EXPECT_LE(range.width(axis), 20);
  }
}

TEST(CoordinateRange, SweepsAlongTheAxisWithTheSmallestShareOfEachBox) {
  for (int thin = 0; thin < 3; ++thin) {
    std::vector<Aabb> boxes(50);
    for (size_t i = 0; i < boxes.size(); ++i) {
      for (int axis = 0; axis < 3; ++axis) {
        boxes[i].min[axis] = static_cast<float>(i);
        boxes[i].max[axis] = boxes[i].min[axis] + (axis == thin ? 0.1F : 20);
      }
    }
    EXPECT_EQ(CoordinateRange::Sample(boxes).sweep_axis, thin);
  }
}

TEST(CoordinateRange, SweepsPointsAlongTheWidestAxis) {
  for (int wide = 0; wide < 3; ++wide) {
    std::vector<Aabb> boxes(10);
    for (size_t i = 0; i < boxes.size(); ++i)
      boxes[i].min[wide] = boxes[i].max[wide] = static_cast<float>(i);
    EXPECT_EQ(CoordinateRange::Sample(boxes).sweep_axis, wide);
  }
}

// Objects often belong to classes that alternate by index.
TEST(CoordinateRange, SamplesAllClassesThatAlternateByIndex) {
  std::vector<Aabb> boxes(128 * 7);
  for (size_t i = 0; i < boxes.size(); ++i) {
    const auto place = static_cast<float>(10 * (i % 7));
    boxes[i] = {{place, place, place}, {place + 1, place + 1, place + 1}};
  }
  const CoordinateRange range = CoordinateRange::Sample(boxes);
  EXPECT_LE(range.low[0], 0);
  EXPECT_GE(range.high[0], 61);
}

TEST(CoordinateRange, IsFiniteInEveryScene) {
  for (const std::string_view name : SceneNames(SceneGroup::kDegenerate)) {
    for (const uint32_t count : {0, 1, 2, 7, 128, 129, 1000}) {
      const auto scene = MakeDegenerateScene(name, count, 3);
      const CoordinateRange range = CoordinateRange::Sample(scene->aabbs());
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_TRUE(std::isfinite(range.low[axis]) && std::isfinite(range.width(axis))) << name;
        EXPECT_GE(range.width(axis), CoordinateRange::kMinWidth) << name;
      }
    }
  }
}

}  // namespace
}  // namespace sweepstake
