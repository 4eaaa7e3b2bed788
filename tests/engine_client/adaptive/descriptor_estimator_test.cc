#include "engine_client/adaptive/descriptor_estimator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "engine_client/scene/random.h"

namespace sweepstake {
namespace {

Aabb Cube(float x, float y, float z, float side) {
  return {{x, y, z}, {x + side, y + side, z + side}};
}

// Returns unit cubes that are uniform in a cube of `world` units.
std::vector<Aabb> Uniform(size_t count, float world, uint64_t seed) {
  SequentialRandom random(seed);
  std::vector<Aabb> boxes;
  for (size_t i = 0; i < count; ++i) {
    boxes.push_back(
        Cube(random.Between(0, world), random.Between(0, world), random.Between(0, world), 1));
  }
  return boxes;
}

SceneDescriptor Describe(std::vector<Aabb> boxes, float step = 0, size_t moving_count = 0) {
  DescriptorEstimator estimator;
  for (uint32_t period = 1;; ++period) {
    while (!estimator.ready()) {
      estimator.Observe(boxes);
      for (size_t i = 0; i < moving_count; ++i) {
        boxes[i].min[0] += step;
        boxes[i].max[0] += step;
      }
    }
    const SceneDescriptor descriptor = estimator.Take();
    if (period == DescriptorEstimator::kShapePeriods) return descriptor;
  }
}

TEST(DescriptorEstimator, IsReadyOncePerPeriod) {
  DescriptorEstimator estimator;
  const auto boxes = Uniform(10, 10, 1);
  for (uint32_t period = 0; period < 3; ++period) {
    for (uint32_t frame = 0; frame < DescriptorEstimator::kPeriodFrames; ++frame) {
      EXPECT_FALSE(estimator.ready());
      estimator.Observe(boxes);
    }
    EXPECT_TRUE(estimator.ready());
    estimator.Take();
  }
}

TEST(DescriptorEstimator, MeasuresOnlyTheCountOfAnEmptyScene) {
  const SceneDescriptor descriptor = Describe({});
  EXPECT_EQ(descriptor.object_count, 0);
  EXPECT_EQ(descriptor.density_ratio, -1);
  EXPECT_EQ(descriptor.size_spread, -1);
  EXPECT_EQ(descriptor.speed_mean, -1);
  EXPECT_EQ(descriptor.clustering_ratio, -1);
  EXPECT_EQ(descriptor.static_ratio, -1);
}

TEST(DescriptorEstimator, EstimatesTheDensityWithinTenPercent) {
  const SceneDescriptor descriptor = Describe(Uniform(5000, 50, 2));
  const double truth = 5000.0 / (51.0 * 51.0 * 51.0);
  EXPECT_NEAR(descriptor.density_ratio, truth, 0.1 * truth);
}

TEST(DescriptorEstimator, EstimatesTheSizeSpread) {
  SequentialRandom random(3);
  std::vector<Aabb> boxes;
  boxes.reserve(2000);
  // ln(side) is uniform in [0, 2], which has a standard deviation of 2 ÷ √12.
  for (int i = 0; i < 2000; ++i) boxes.push_back(Cube(0, 0, 0, std::exp(random.Between(0, 2))));
  EXPECT_NEAR(Describe(boxes).size_spread, 2 / std::sqrt(12.0), 0.05);
}

TEST(DescriptorEstimator, EstimatesSpeedAndStaticShare) {
  const SceneDescriptor all = Describe(Uniform(200, 20, 4), 0.25F, 200);
  EXPECT_NEAR(all.speed_mean, 0.25, 1e-4);
  EXPECT_NEAR(all.speed_spread, 0, 1e-2);
  EXPECT_EQ(all.static_ratio, 0);
  const SceneDescriptor half = Describe(Uniform(1000, 20, 4), 0.25F, 500);
  EXPECT_NEAR(half.static_ratio, 0.5, 0.05);
  EXPECT_NEAR(half.speed_mean, 0.125, 0.02);
}

TEST(DescriptorEstimator, MeasuresTheMotionOfEachPeriodAndTheShapeOfSeveral) {
  DescriptorEstimator estimator;
  const auto describe = [&](std::vector<Aabb> boxes, float step) {
    while (!estimator.ready()) {
      estimator.Observe(boxes);
      for (Aabb& box : boxes) {
        box.min[0] += step;
        box.max[0] += step;
      }
    }
    return estimator.Take();
  };
  const std::vector<Aabb> boxes = Uniform(1000, 20, 9);
  const SceneDescriptor first = describe(boxes, 0.25F);
  EXPECT_NEAR(first.speed_mean, 0.25, 1e-4);
  EXPECT_GT(first.density_ratio, 0);
  for (uint32_t i = 1; i < DescriptorEstimator::kShapePeriods; ++i) describe(boxes, 0);
  const SceneDescriptor resting = describe(Uniform(1000, 40, 9), 0);
  EXPECT_EQ(resting.speed_mean, 0);
  EXPECT_EQ(resting.static_ratio, 1);
  EXPECT_NEAR(resting.density_ratio, 1000.0 / (20 * 20 * 20), 0.06);
  for (uint32_t i = 1; i < DescriptorEstimator::kShapePeriods; ++i) {
    const float density = describe(Uniform(1000, 40, 9), 0).density_ratio;
    if (i + 1 == DescriptorEstimator::kShapePeriods) {
      EXPECT_NEAR(density, 1000.0 / (40 * 40 * 40), 0.01);
    }
  }
}

TEST(DescriptorEstimator, DistinguishesAClusteredSceneFromAUniformOne) {
  const SceneDescriptor uniform = Describe(Uniform(200, 40, 5));
  EXPECT_NEAR(uniform.clustering_ratio, 1, 0.6);
  std::vector<Aabb> clustered = Uniform(200, 2, 6);
  clustered.push_back(Cube(40, 40, 40, 1));
  EXPECT_GT(Describe(clustered).clustering_ratio, 50);
}

TEST(DescriptorEstimator, MeasuresNoMotionWhileTheObjectCountChanges) {
  DescriptorEstimator estimator;
  std::vector<Aabb> boxes = Uniform(100, 20, 7);
  while (!estimator.ready()) {
    estimator.Observe(boxes);
    boxes.push_back(boxes.front());
  }
  const SceneDescriptor descriptor = estimator.Take();
  EXPECT_EQ(descriptor.speed_mean, -1);
  EXPECT_GT(descriptor.density_ratio, 0);
}

TEST(DescriptorEstimator, StaysFiniteWithInvalidAndHugeBoxes) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  std::vector<Aabb> boxes(50, Aabb{{kNan, 0, 0}, {1, 1, 1}});
  boxes.push_back({{-1e30F, -1e30F, -1e30F}, {1e30F, 1e30F, 1e30F}});
  boxes.push_back({{-3e38F, -3e38F, -3e38F}, {3e38F, 3e38F, 3e38F}});
  const SceneDescriptor descriptor = Describe(boxes);
  for (const float value :
       {descriptor.density_ratio, descriptor.size_spread, descriptor.speed_mean,
        descriptor.speed_spread, descriptor.clustering_ratio, descriptor.static_ratio}) {
    EXPECT_TRUE(std::isfinite(value));
  }
}

TEST(DescriptorEstimator, SamplesObjectsFromAllOfALargeScene) {
  std::vector<Aabb> boxes = Uniform(100'000, 100, 8);
  EXPECT_NEAR(Describe(boxes, 1, 25'000).static_ratio, 0.75, 0.03);
}

}  // namespace
}  // namespace sweepstake
