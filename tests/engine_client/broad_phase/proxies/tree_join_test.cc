// Tests the search between two trees: its results for boxes that are close together, apart or
// large, and how many checks it takes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "engine_client/broad_phase/kd/kd_order.h"
#include "engine_client/broad_phase/kd/leaf_tree.h"
#include "engine_client/broad_phase/proxies/tree_walk.h"
#include "engine_client/scene/random.h"
#include "sweepstake/proxy_set.h"
#include "tests/engine_client/broad_phase/each_simd_target.h"

namespace sweepstake {
namespace {

// Returns boxes with edges of 0.5 units, at random places in a cube.
std::vector<Aabb> BoxesWithin(float side, size_t count, uint64_t seed) {
  SequentialRandom random(seed);
  std::vector<Aabb> boxes(count);
  for (Aabb& box : boxes) {
    for (size_t axis = 0; axis < 3; ++axis) {
      box.min[axis] = random.Between(0, side);
      box.max[axis] = box.min[axis] + 0.5F;
    }
  }
  return boxes;
}

LeafTree TreeOf(const std::vector<Aabb>& boxes) {
  std::vector<uint32_t> order(boxes.size());
  for (uint32_t k = 0; k < order.size(); ++k) order[k] = k;
  KdOrder splitter;
  splitter.Sort(boxes, order);
  LeafTree tree;
  tree.Refit(boxes, order, nullptr);
  return tree;
}

struct Found {
  std::vector<OverlapPair> pairs;
  uint64_t checks = 0;
};

Found Join(const LeafTree& movers, const LeafTree& others) {
  PairBuffer pairs;
  const uint64_t checks = FindPairsBetween(movers.view(), 0, movers.view().levels[1].count,
                                           others.view(), kStaticProxyBit, pairs);
  return {{pairs.pairs().begin(), pairs.pairs().end()}, checks};
}

std::vector<OverlapPair> PairsByDefinition(const std::vector<Aabb>& movers,
                                           const std::vector<Aabb>& others) {
  std::vector<OverlapPair> pairs;
  for (uint32_t a = 0; a < movers.size(); ++a) {
    for (uint32_t b = 0; b < others.size(); ++b) {
      if (Overlap(movers[a], others[b])) pairs.push_back({a, kStaticProxyBit | b});
    }
  }
  return pairs;
}

// The density is constant: each mover has as many near boxes in a large world as in a small one.
uint64_t ChecksAmong(size_t static_count) {
  const float side = std::cbrt(static_cast<float>(static_count));
  const Found found =
      Join(TreeOf(BoxesWithin(side, 200, 1)), TreeOf(BoxesWithin(side, static_count, 2)));
  EXPECT_GT(found.pairs.size(), 100U);
  EXPECT_LT(found.pairs.size(), 300U);
  return found.checks;
}

TEST(AJoinOfBoxesThatStandApart, NeedsFewMoreChecksAmongSixteenTimesAsManyBoxes) {
  const uint64_t few = ChecksAmong(20'000);
  const uint64_t many = ChecksAmong(320'000);
  // The larger tree has one more level, and each search passes about five levels.
  EXPECT_LT(static_cast<double>(many), 1.5 * static_cast<double>(few));
  EXPECT_LT(many, 200U * 600);
}

TEST(AJoin, SearchesNoFurtherBlockAfterAStop) {
  class Stop final : public StopRequest {
   public:
    bool WantsStop(uint64_t, uint64_t) noexcept override { return true; }
  } stop;
  const std::vector<Aabb> boxes(20 * LeafTree::kBlockSlots, Aabb{{0, 0, 0}, {1, 1, 1}});
  const LeafTree tree = TreeOf(boxes);
  const auto checks_of = [&](size_t leaf_count) {
    PairBuffer pairs;
    return FindPairsBetween(tree.view(), 0, leaf_count, tree.view(), kStaticProxyBit, pairs, &stop);
  };
  EXPECT_EQ(checks_of(20 * LeafTree::kWidth), checks_of(LeafTree::kWidth));
}

TEST(AJoin, FindsAllPairsWithTheSameChecksOnEachInstructionSet) {
  const std::vector<Aabb> others = BoxesWithin(32, 20'000, 3);
  std::vector<Aabb> movers = BoxesWithin(32, 300, 4);  // apart
  for (const Aabb& box : BoxesWithin(4, 300, 5)) movers.push_back(box);
  movers.push_back({{0, 0, 0}, {32, 32, 1}});
  movers.push_back({{8, 8, 8}, {24, 24, 24}});
  movers.push_back({{1, 0, 0}, {0, 1, 1}});  // invalid
  const LeafTree mover_tree = TreeOf(movers);
  const LeafTree other_tree = TreeOf(others);
  const std::vector<OverlapPair> expected = PairsByDefinition(movers, others);
  const uint64_t checks = Join(mover_tree, other_tree).checks;
  test_support::OnEachSimdTarget([&] {
    Found found = Join(mover_tree, other_tree);
    EXPECT_TRUE(Join(mover_tree, other_tree).pairs == found.pairs)
        << "the order of the pairs differs";
    EXPECT_EQ(found.checks, checks);
    std::ranges::sort(found.pairs);
    EXPECT_TRUE(found.pairs == expected);
  });
}

}  // namespace
}  // namespace sweepstake
