// What is DBVT's own: the tree stays a hierarchy and low, and cost follows motion.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "engine_client/broad_phase/dbvt_query.h"
#include "engine_client/broad_phase/dbvt_tree.h"
#include "tests/engine_client/broad_phase/backend_under_test.h"
#include "tests/support/box_scenes.h"

namespace sweepstake {
namespace {

using test_support::BoxScene;
using test_support::MakeOrThrow;
using test_support::PairDifference;
using test_support::Random;
using test_support::ScalarPairs;
using test_support::Verdict;

Aabb RandomBox(Random& random) {
  Aabb box{};
  for (int axis = 0; axis < 3; ++axis) {
    box.min[axis] = random.Between(0, 20);
    box.max[axis] = box.min[axis] + random.Between(0, 2);
  }
  return box;
}

Aabb Joined(const Aabb& a, const Aabb& b) {
  Aabb joined{};
  for (int axis = 0; axis < 3; ++axis) {
    joined.min[axis] = std::min(a.min[axis], b.min[axis]);
    joined.max[axis] = std::max(a.max[axis], b.max[axis]);
  }
  return joined;
}

// The first thing that is wrong below `node`, empty when nothing is; leaves met go to `leaves`.
std::string FaultBelow(const DbvtTree& tree, uint32_t node, std::vector<uint32_t>& leaves) {
  if (tree.IsLeaf(node)) {
    leaves.push_back(node);
    if (tree.height(node) != 0) return "a leaf has a height";
    return tree.Contains(node) ? "" : "a leaf that was removed is linked";
  }
  const uint32_t children[2] = {tree.nodes()[node].first, tree.nodes()[node].second};
  for (const uint32_t child : children) {
    if (tree.parent(child) != node) return "a child has another parent";
    std::string fault = FaultBelow(tree, child, leaves);
    if (!fault.empty()) return fault;
  }
  if (!(tree.box(node) == Joined(tree.box(children[0]), tree.box(children[1])))) {
    return "a box is not the union of its children's";
  }
  const uint32_t below = std::max(tree.height(children[0]), tree.height(children[1]));
  return tree.height(node) == below + 1 ? "" : "a height is wrong";
}

std::string FaultOf(const DbvtTree& tree) {
  std::vector<uint32_t> leaves;
  if (tree.root() == DbvtTree::kNone) return tree.size() == 0 ? "" : "a tree has lost its root";
  if (tree.parent(tree.root()) != DbvtTree::kNone) return "the root has a parent";
  std::string fault = FaultBelow(tree, tree.root(), leaves);
  if (!fault.empty()) return fault;
  std::sort(leaves.begin(), leaves.end());
  if (std::adjacent_find(leaves.begin(), leaves.end()) != leaves.end()) return "a leaf is twice";
  if (leaves.size() != tree.size()) return "leaves are missing";
  return tree.height() <= DbvtTree::MaxHeight(tree.size()) ? "" : "the tree is too high";
}

TEST(DbvtTree, IsEmptyAfterReset) {
  DbvtTree tree;
  tree.Reset(3);
  EXPECT_EQ(tree.root(), DbvtTree::kNone);
  EXPECT_EQ(tree.height(), 0U);
  tree.Rebuild();
  EXPECT_EQ(FaultOf(tree), "");
}

TEST(DbvtTree, StaysAHierarchyUnderRandomInsertionsMovesAndRemovals) {
  Random random(1);
  DbvtTree tree;
  tree.Reset(200);
  for (int step = 0; step < 5000; ++step) {
    const auto leaf = static_cast<uint32_t>(random.Below(200));
    if (!tree.Contains(leaf)) {
      tree.Insert(leaf, RandomBox(random));
    } else if (random.Below(3) == 0) {
      tree.Remove(leaf);
    } else {
      tree.Move(leaf, RandomBox(random));
    }
    ASSERT_EQ(FaultOf(tree), "") << "after step " << step;
  }
}

TEST(DbvtTree, StaysAHierarchyUnderBulkChanges) {
  Random random(2);
  DbvtTree tree;
  tree.Reset(300);
  for (uint32_t leaf = 0; leaf < 250; ++leaf) tree.SetBox(leaf, RandomBox(random));
  tree.Rebuild();
  EXPECT_EQ(FaultOf(tree), "");
  EXPECT_EQ(tree.height(), 8U) << "median splits of 250 leaves";
  for (uint32_t leaf = 0; leaf < 250; ++leaf) tree.SetBox(leaf, RandomBox(random));
  tree.Refit();
  EXPECT_EQ(FaultOf(tree), "");
  for (uint32_t leaf = 250; leaf < 300; ++leaf) tree.Insert(leaf, RandomBox(random));
  EXPECT_EQ(FaultOf(tree), "");
  EXPECT_EQ(tree.size(), 300U);
}

TEST(DbvtTree, StaysLowWhenAllBoxesCoincide) {
  DbvtTree tree;
  tree.Reset(4096);
  const Aabb box{{1, 2, 3}, {4, 5, 6}};
  for (uint32_t leaf = 0; leaf < 4096; ++leaf) tree.Insert(leaf, box);
  EXPECT_EQ(FaultOf(tree), "");
  EXPECT_LE(tree.height(), 18U) << "1.44 log2(n), as of a balanced tree";
}

TEST(DbvtTree, StaysLowWhenBoxesComeInARow) {
  DbvtTree tree;
  tree.Reset(4096);
  for (uint32_t leaf = 0; leaf < 4096; ++leaf) {
    const auto x = static_cast<float>(leaf);
    tree.Insert(leaf, {{x, 0, 0}, {x + 0.5F, 0, 0}});
  }
  EXPECT_EQ(FaultOf(tree), "");
  EXPECT_LE(tree.height(), DbvtTree::MaxHeight(4096));
}

TEST(DbvtTree, TakesTheLargestFloats) {
  constexpr float kLargest = 3.4028235e38F;
  DbvtTree tree;
  tree.Reset(64);
  for (uint32_t leaf = 0; leaf < 64; ++leaf) {
    const float side = leaf % 2 == 0 ? kLargest : 1;
    tree.Insert(leaf, {{-side, -side, -side}, {side, side, side}});
  }
  EXPECT_EQ(FaultOf(tree), "");
  tree.Rebuild();
  EXPECT_EQ(FaultOf(tree), "");
}

TEST(DbvtQuery, FindsThePairsOfSomeLeavesOnce) {
  Random random(4);
  std::vector<Aabb> boxes;
  DbvtTree tree;
  tree.Reset(200);
  for (uint32_t leaf = 0; leaf < 200; ++leaf) {
    boxes.push_back(RandomBox(random));
    tree.Insert(leaf, boxes.back());
  }
  std::vector<uint32_t> listed;
  std::vector<uint8_t> is_listed(200, 0);
  for (uint32_t leaf = 0; leaf < 200; leaf += 3) {
    listed.push_back(leaf);
    is_listed[leaf] = 1;
  }
  std::vector<OverlapPair> expected = ScalarPairs(boxes);
  std::erase_if(expected,
                [](const OverlapPair& pair) { return pair.a % 3 != 0 && pair.b % 3 != 0; });
  PairBuffer pairs;
  FindLeafPairsOf(tree, listed, is_listed.data(), pairs);
  EXPECT_EQ(PairDifference(pairs.pairs(), expected), "");
}

uint64_t ChecksOfFrame(BroadPhase& backend, BoxScene& scene) {
  PairBuffer pairs;
  scene.Step();
  backend.Update(scene.boxes());
  backend.FindPairs(pairs);
  return backend.aabb_check_count();
}

TEST(Dbvt, LooksAtNoTreeWhileBoxesStayInsideTheirMargins) {
  const auto backend = MakeOrThrow("DBVT");
  BoxScene scene("brownian", 1000, 8);
  PairBuffer pairs;
  backend->Build(scene.boxes());
  backend->Update(scene.boxes());
  backend->FindPairs(pairs);
  // One comparison with each enlarged box, and the candidates: few more than the pairs.
  EXPECT_LE(backend->aabb_check_count(), 1000 + 2 * pairs.size());
}

TEST(Dbvt, CostsLessTheLessMoves) {
  const auto moving = MakeOrThrow("DBVT");
  const auto resting = MakeOrThrow("DBVT");
  BoxScene much("brownian", 2000, 8);
  BoxScene little("nearly-resting", 2000, 8);
  moving->Build(much.boxes());
  resting->Build(little.boxes());
  uint64_t much_checks = 0;
  uint64_t little_checks = 0;
  for (int frame = 0; frame < 20; ++frame) {
    much_checks += ChecksOfFrame(*moving, much);
    little_checks += ChecksOfFrame(*resting, little);
  }
  EXPECT_LT(little_checks * 3, much_checks);
}

TEST(Dbvt, ShowsNothingOfItsMargins) {
  const auto backend = MakeOrThrow("DBVT");
  PairBuffer pairs;
  std::vector<Aabb> boxes = {{{0, 0, 0}, {1, 1, 1}}, {{1.001F, 0, 0}, {2, 1, 1}}};
  backend->Build(boxes);
  EXPECT_EQ(Verdict(*backend, boxes, pairs), "");
  EXPECT_TRUE(pairs.empty());
  boxes[1].min[0] = 1;
  backend->Update(boxes);
  EXPECT_EQ(Verdict(*backend, boxes, pairs), "");
  EXPECT_EQ(pairs.size(), 1U);
}

}  // namespace
}  // namespace sweepstake
