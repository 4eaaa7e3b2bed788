// What is KDTree's own: the order, the implicit tree over it, and how long the order is kept.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "engine_client/broad_phase/kd_order.h"
#include "engine_client/broad_phase/leaf_tree.h"
#include "engine_client/broad_phase/soa_boxes.h"
#include "tests/engine_client/broad_phase/backend_under_test.h"
#include "tests/support/box_scenes.h"

namespace sweepstake {
namespace {

using test_support::BoxScene;
using test_support::MakeOrThrow;
using test_support::PairDifference;
using test_support::ScalarPairs;

std::vector<uint32_t> Identity(size_t count) {
  std::vector<uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0U);
  return order;
}

TEST(KdOrder, IsAPermutation) {
  for (const size_t count : {0, 1, 15, 16, 17, 256, 257, 300, 5000}) {
    const BoxScene scene("mixture", count, 3);
    std::vector<uint32_t> order = Identity(count);
    KdOrder splitter;
    splitter.Sort(scene.boxes(), order);
    std::sort(order.begin(), order.end());
    EXPECT_EQ(order, Identity(count));
  }
}

TEST(KdOrder, PutsBoxesThatTakeNoPartLast) {
  const BoxScene scene("broken-boxes", 500, 3);
  std::vector<uint32_t> order = Identity(500);
  KdOrder splitter;
  splitter.Sort(scene.boxes(), order);
  EXPECT_TRUE(std::is_partitioned(order.begin(), order.end(),
                                  [&](uint32_t i) { return TakesPart(scene.boxes()[i]); }));
}

TEST(KdOrder, SplitsALineInOrder) {
  std::vector<Aabb> boxes;
  for (uint32_t i = 0; i < 256; ++i) {
    const auto x = static_cast<float>((i * 37) % 256);
    boxes.push_back({{x, 0, 0}, {x, 1, 1}});
  }
  std::vector<uint32_t> order = Identity(256);
  KdOrder splitter;
  splitter.Sort(boxes, order);
  for (size_t slot = 0; slot < 256; ++slot) {
    EXPECT_EQ(static_cast<size_t>(boxes[order[slot]].min[0]) / 16, slot / 16);
  }
}

TEST(KdOrder, DoesNotDependOnHowOftenCoincidentBoxesAreSorted) {
  const BoxScene scene("all-coincident", 1000, 3);
  std::vector<uint32_t> order = Identity(1000);
  KdOrder splitter;
  for (int round = 0; round < 3; ++round) splitter.Sort(scene.boxes(), order);
  std::sort(order.begin(), order.end());
  EXPECT_EQ(order, Identity(1000));
}

TEST(LeafTree, BoundsEverythingBelowEachNode) {
  const BoxScene scene("mixture", 5000, 5);
  SoaBoxes boxes;
  boxes.Gather(scene.boxes());
  const BoxLanes lanes = boxes.Lanes();
  LeafTree tree;
  tree.Refit(lanes);
  ASSERT_EQ(tree.level_count(), 3U);
  size_t width = 1;
  for (size_t index = 0; index < tree.level_count(); ++index) {
    width *= LeafTree::kWidth;
    const LeafTree::Level& level = tree.level(index);
    EXPECT_EQ(level.count, (5000 + width - 1) / width);
    for (size_t slot = 0; slot < lanes.count; ++slot) {
      for (size_t axis = 0; axis < 3; ++axis) {
        ASSERT_LE(level.min[axis][slot / width], lanes.min[axis][slot]);
        ASSERT_GE(level.max[axis][slot / width], lanes.max[axis][slot]);
      }
    }
  }
}

TEST(LeafTree, FindsAllPairsInAnyOrder) {
  const BoxScene scene("brownian", 1000, 5);
  SoaBoxes boxes;
  boxes.Gather(scene.boxes());  // unordered: slow, and right
  LeafTree tree;
  PairBuffer pairs;
  tree.Refit(boxes.Lanes());
  tree.FindPairs(boxes.Lanes(), pairs);
  EXPECT_EQ(PairDifference(pairs.pairs(), ScalarPairs(scene.boxes())), "");
}

// Checks of each frame.
std::vector<uint64_t> Checks(BroadPhase& backend, BoxScene& scene, int frames) {
  std::vector<uint64_t> checks;
  PairBuffer pairs;
  for (int frame = 0; frame < frames; ++frame) {
    scene.Step();
    pairs.Clear();
    backend.Update(scene.boxes());
    backend.FindPairs(pairs);
    checks.push_back(backend.aabb_check_count());
  }
  return checks;
}

uint64_t ChecksOfFreshBuild(const BoxScene& scene) {
  const auto backend = MakeOrThrow("KDTree");
  PairBuffer pairs;
  backend->Build(scene.boxes());
  backend->FindPairs(pairs);
  return backend->aabb_check_count();
}

TEST(KdTree, SplitsAnewBeforeMotionHasSpoiltTheOrder) {
  const auto backend = MakeOrThrow("KDTree");
  BoxScene scene("brownian", 3000, 5);
  backend->Build(scene.boxes());
  const std::vector<uint64_t> checks = Checks(*backend, scene, 300);
  EXPECT_LE(*std::max_element(checks.begin(), checks.end()), 3 * ChecksOfFreshBuild(scene));
}

TEST(KdTree, KeepsTheOrderForSeveralFrames) {
  const auto backend = MakeOrThrow("KDTree");
  BoxScene scene("brownian", 3000, 5);
  backend->Build(scene.boxes());
  const std::vector<uint64_t> checks = Checks(*backend, scene, 100);
  // A split shows as a frame with clearly fewer checks than the one before.
  int splits = 0;
  for (size_t i = 1; i < checks.size(); ++i) splits += checks[i] * 100 < checks[i - 1] * 95 ? 1 : 0;
  EXPECT_GE(splits, 2);
  EXPECT_LE(splits, 30);
}

TEST(KdTree, NeverSplitsAnewWhatRests) {
  const auto backend = MakeOrThrow("KDTree");
  const BoxScene scene("brownian", 3000, 5);
  PairBuffer first;
  backend->Build(scene.boxes());
  backend->FindPairs(first);
  for (int frame = 0; frame < 100; ++frame) {
    PairBuffer pairs;
    backend->Update(scene.boxes());
    backend->FindPairs(pairs);
    // The order of the pairs shows the order of the boxes.
    ASSERT_TRUE(std::ranges::equal(pairs.pairs(), first.pairs()));
  }
}

}  // namespace
}  // namespace sweepstake
