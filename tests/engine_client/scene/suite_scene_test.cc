#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "tests/engine_client/scene/scene_fixtures.h"

namespace sweepstake {
namespace {

// Counts the pairs with a sweep along x and a full test of the candidates.
uint64_t CountPairs(std::span<const Aabb> boxes, std::vector<Aabb>& sorted) {
  sorted.assign(boxes.begin(), boxes.end());
  std::sort(sorted.begin(), sorted.end(),
            [](const Aabb& a, const Aabb& b) { return a.min[0] < b.min[0]; });
  uint64_t count = 0;
  for (size_t i = 0; i < sorted.size(); ++i) {
    for (size_t j = i + 1; j < sorted.size() && sorted[j].min[0] <= sorted[i].max[0]; ++j) {
      count += Overlap(sorted[i], sorted[j]) ? 1 : 0;
    }
  }
  return count;
}

// Returns the mean number of pairs in frames 21 to 140, as in the published table.
double MeanPairs(std::string_view name, uint32_t object_count) {
  const std::unique_ptr<Scene> scene = MustMakeScene(name, WithCount(object_count));
  std::vector<Aabb> sorted;
  StepTimes(*scene, 20);
  uint64_t pairs = 0;
  for (int frame = 21; frame <= 140; ++frame) {
    scene->Step();
    pairs += CountPairs(scene->aabbs(), sorted);
  }
  return static_cast<double>(pairs) / 120;
}

struct PublishedMean {
  std::string_view scene;
  uint32_t object_count;
  long mean_pairs;
};

std::string NameOfCase(const testing::TestParamInfo<PublishedMean>& tested) {
  std::string name(tested.param.scene);
  std::replace(name.begin(), name.end(), '-', '_');
  return name + "_" + std::to_string(tested.param.object_count);
}

class PublishedTable : public testing::TestWithParam<PublishedMean> {};

TEST_P(PublishedTable, HasTheSameMeanPairs) {
  const PublishedMean& published = GetParam();
  const double mean = MeanPairs(published.scene, published.object_count);
  EXPECT_EQ(std::lround(mean), published.mean_pairs);
}

INSTANTIATE_TEST_SUITE_P(
    ReferenceSuite, PublishedTable,
    testing::Values(PublishedMean{"suite-b", 1000, 1379}, PublishedMean{"suite-g", 1000, 9529},
                    PublishedMean{"suite-h", 1000, 2096}, PublishedMean{"suite-b", 3000, 4214},
                    PublishedMean{"suite-g", 3000, 30931}, PublishedMean{"suite-h", 3000, 6655}),
    NameOfCase);

TEST(ReferenceSuite, WorldHasDensityOne) {
  const Aabb world = MustMakeScene("suite-b", WithCount(8000))->world();
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(world.min[axis], 0);
    EXPECT_EQ(world.max[axis], 20);
  }
}

TEST(ReferenceSuite, OnlyTheObjectCountChangesIt) {
  SceneOptions other = WithCount(50);
  other.spawn_seed = 99;
  other.motion_seed = 98;
  other.speed = 1;
  other.fixed_step_s = 0.5F;
  for (const std::string_view name : {"suite-b", "suite-g", "suite-h"}) {
    EXPECT_EQ(HashOfFrames(*MustMakeScene(name, other), 40),
              HashOfFrames(*MustMakeScene(name, WithCount(50)), 40));
  }
}

}  // namespace
}  // namespace sweepstake
