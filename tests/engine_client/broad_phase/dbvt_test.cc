// Tests the parts that only DBVT has: the tree stays valid, and its cost follows the motion.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "engine_client/broad_phase/dbvt/dbvt_query.h"
#include "engine_client/broad_phase/dbvt/dbvt_tree.h"
#include "engine_client/scene/box_scenes.h"
#include "tests/engine_client/broad_phase/backend_under_test.h"

namespace sweepstake {
namespace {

using test_support::FindPairsError;
using test_support::MakeOrThrow;
using test_support::PairDifference;
using test_support::ScalarPairs;

Aabb RandomBox(SequentialRandom& random) {
  Aabb box{};
  for (int axis = 0; axis < 3; ++axis) {
    box.min[axis] = random.Between(0, 20);
    box.max[axis] = box.min[axis] + random.Between(0, 2);
  }
  return box;
}

// Finds the first error of a tree that should contain these objects with these boxes; the
// description is empty if there is none.
class TreeInspection {
 public:
  TreeInspection(const DbvtTree& tree, std::span<const Aabb> boxes) : tree_(tree), boxes_(boxes) {}

  std::string Fault() {
    if (tree_.links()[tree_.root()].level == 0) return "the root is a leaf";
    if (tree_.links()[tree_.root()].parent != DbvtTree::kNone) return "the root has a parent";
    std::string fault = FaultIn(tree_.root());
    if (!fault.empty()) return fault;
    for (uint32_t object = 0; object < tree_.object_count(); ++object) {
      if (tree_.Contains(object) != met_.contains(object)) return "an object is lost";
    }
    return "";
  }
  size_t size() const { return met_.size(); }
  size_t leaf_count() const { return leaf_count_; }

 private:
  std::string FaultIn(uint32_t node) {
    const DbvtLink link = tree_.links()[node];
    leaf_count_ += link.level == 0 ? 1 : 0;
    for (uint32_t lane = 0; lane < DbvtTree::kWidth; ++lane) {
      std::string fault = lane >= link.count ? FaultInEmpty(node, lane)
                          : link.level == 0  ? FaultInObject(node, lane)
                                             : FaultInChild(node, lane);
      if (!fault.empty()) return fault;
    }
    return "";
  }

  std::string FaultInEmpty(uint32_t node, uint32_t lane) const {
    const Aabb box = BoxOf(node, lane);
    return box.min[0] > box.max[0] ? "" : "a lane behind the last is not empty";
  }

  std::string FaultInObject(uint32_t node, uint32_t lane) {
    const uint32_t object = tree_.nodes()[node].child[lane];
    if (!met_.insert(object).second) return "an object is there twice";
    return BoxOf(node, lane) == boxes_[object] ? "" : "an object has another box";
  }

  std::string FaultInChild(uint32_t node, uint32_t lane) {
    const uint32_t child = tree_.nodes()[node].child[lane];
    const DbvtLink link = tree_.links()[child];
    if (link.parent != node || link.lane != lane) return "a child hangs elsewhere";
    if (link.level + 1 != tree_.links()[node].level) return "leaves differ in depth";
    if (link.count == 0) return "a node is empty";
    const Aabb around = BoxOf(node, lane);
    for (uint32_t k = 0; k < link.count; ++k) {
      const Aabb inner = BoxOf(child, k);
      for (int axis = 0; axis < 3; ++axis) {
        if (around.min[axis] > inner.min[axis] || around.max[axis] < inner.max[axis]) {
          return "a box does not cover what is below";
        }
      }
    }
    return FaultIn(child);
  }

  Aabb BoxOf(uint32_t node, uint32_t lane) const {
    const DbvtNode& at = tree_.nodes()[node];
    return {{at.min[0][lane], at.min[1][lane], at.min[2][lane]},
            {at.max[0][lane], at.max[1][lane], at.max[2][lane]}};
  }

  const DbvtTree& tree_;
  std::span<const Aabb> boxes_;
  std::set<uint32_t> met_;
  size_t leaf_count_ = 0;
};

std::string FaultOf(const DbvtTree& tree, std::span<const Aabb> boxes) {
  return TreeInspection(tree, boxes).Fault();
}

std::vector<Aabb> RandomBoxes(SequentialRandom& random, size_t count) {
  std::vector<Aabb> boxes(count);
  for (Aabb& box : boxes) box = RandomBox(random);
  return boxes;
}

std::vector<uint32_t> FirstNumbers(size_t count) {
  std::vector<uint32_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), 0U);
  return numbers;
}

void BuildOf(DbvtTree& tree, std::span<const Aabb> boxes, std::span<const uint32_t> slots) {
  HookedVector<uint32_t> lost;
  tree.Build(boxes, slots, nullptr, lost);
  EXPECT_TRUE(lost.empty());
}

std::vector<OverlapPair> AllPairs(DbvtTree& tree) {
  PairBuffer pairs;
  FindGroupPairs(tree, tree.Groups(), pairs, nullptr);
  return {pairs.pairs().begin(), pairs.pairs().end()};
}

TEST(DbvtTree, IsEmptyIfBuiltFromNoObjects) {
  DbvtTree tree;
  BuildOf(tree, {}, {});
  EXPECT_EQ(FaultOf(tree, {}), "");
  EXPECT_TRUE(AllPairs(tree).empty());
  tree.Settle();
  EXPECT_EQ(FaultOf(tree, {}), "");
}

TEST(DbvtTree, FillsItsLeavesWhenBuilt) {
  SequentialRandom random(1);
  for (const size_t count : {1, 2, 16, 17, 255, 256, 257, 5000}) {
    const std::vector<Aabb> boxes = RandomBoxes(random, count);
    DbvtTree tree;
    BuildOf(tree, boxes, FirstNumbers(count));
    TreeInspection inspection(tree, boxes);
    EXPECT_EQ(inspection.Fault(), "") << count;
    EXPECT_EQ(inspection.size(), count);
    EXPECT_GE(inspection.leaf_count(), (count + 15) / 16);
    EXPECT_LE(inspection.leaf_count(), count / 12 + 2);
  }
}

TEST(DbvtTree, KeepsGapsAndReportsInvalidObjectsAsLost) {
  SequentialRandom random(1);
  std::vector<Aabb> boxes = RandomBoxes(random, 40);
  boxes[7].min[1] = 1e9F;
  std::vector<uint32_t> slots(64, DbvtTree::kNone);
  for (uint32_t object = 0; object < 30; ++object) slots[2 * object] = object;
  slots[63] = 40;  // an object that has been removed
  HookedVector<uint32_t> lost;
  DbvtTree tree;
  tree.Build(boxes, slots, nullptr, lost);
  TreeInspection inspection(tree, boxes);
  EXPECT_EQ(inspection.Fault(), "");
  EXPECT_EQ(inspection.size(), 29U);
  EXPECT_EQ(lost, HookedVector<uint32_t>{7});
}

TEST(DbvtTree, StaysValidUnderRandomInsertionsMovesAndRemovals) {
  SequentialRandom random(1);
  std::vector<Aabb> boxes = RandomBoxes(random, 600);
  DbvtTree tree;
  BuildOf(tree, boxes, FirstNumbers(200));
  for (int step = 0; step < 6000; ++step) {
    const auto object = static_cast<uint32_t>(random.Below(600));
    if (!tree.Contains(object)) {
      tree.Insert(object, boxes[object]);
    } else if (random.Below(step < 4000 ? 3 : 1) == 0) {
      tree.Remove(object);
    } else {
      boxes[object] = RandomBox(random);
      tree.Move(object, boxes[object]);
    }
    if (step % 16 == 0) {
      ASSERT_EQ(FaultOf(tree, boxes), "") << "after step " << step;
    }
  }
}

TEST(DbvtTree, CanBeEmptiedAndFilledAgain) {
  SequentialRandom random(2);
  const std::vector<Aabb> boxes = RandomBoxes(random, 700);
  DbvtTree tree;
  BuildOf(tree, boxes, FirstNumbers(700));
  for (int round = 0; round < 3; ++round) {
    for (uint32_t object = 0; object < 700; ++object) tree.Remove(object);
    ASSERT_EQ(FaultOf(tree, boxes), "");
    for (uint32_t object = 0; object < 700; ++object) tree.Insert(object, boxes[object]);
    ASSERT_EQ(FaultOf(tree, boxes), "");
    EXPECT_EQ(AllPairs(tree).size(), ScalarPairs(boxes).size());
  }
}

TEST(DbvtTree, FollowsMovingBoxes) {
  BoxScene scene("brownian", 600, 3);
  HookedVector<uint32_t> lost;
  DbvtTree tree;
  BuildOf(tree, scene.boxes(), {});
  for (uint32_t object = 0; object < 600; ++object) tree.Insert(object, scene.boxes()[object]);
  size_t moved_elsewhere = 0;
  for (int frame = 0; frame < 40; ++frame) {
    scene.Step();
    tree.Refit(scene.boxes(), 0.1F, nullptr, lost);
    moved_elsewhere += tree.waiting_count();
    tree.Settle();
    ASSERT_EQ(FaultOf(tree, scene.boxes()), "") << "in frame " << frame;
    ASSERT_EQ(PairDifference(AllPairs(tree), ScalarPairs(scene.boxes())), "");
  }
  EXPECT_TRUE(lost.empty());
  EXPECT_GT(moved_elsewhere, 0U);
}

TEST(DbvtTree, RefitReportsTheMotion) {
  SequentialRandom random(5);
  std::vector<Aabb> boxes = RandomBoxes(random, 160);
  HookedVector<uint32_t> lost;
  DbvtTree tree;
  BuildOf(tree, boxes, FirstNumbers(160));
  for (Aabb& box : boxes) box.min[1] -= 0.5F;
  const DbvtTree::Motion motion = tree.Refit(boxes, 1, nullptr, lost);
  EXPECT_EQ(motion.sample_count, 10U) << "one sample from each leaf";
  EXPECT_EQ(motion.fast_count, 0U);
  EXPECT_NEAR(motion.mean, 0.5F, 1e-5F);
  for (Aabb& box : boxes) box.min[1] -= 2;
  EXPECT_EQ(tree.Refit(boxes, 1, nullptr, lost).fast_count, 10U);
}

TEST(DbvtTree, RemovesObjectsWithInvalidBoxes) {
  SequentialRandom random(6);
  std::vector<Aabb> boxes = RandomBoxes(random, 100);
  HookedVector<uint32_t> lost;
  DbvtTree tree;
  BuildOf(tree, boxes, FirstNumbers(100));
  for (size_t object = 0; object < 100; object += 3) boxes[object].max[2] = -1e9F;
  tree.Refit(boxes, 1, nullptr, lost);
  tree.Settle();
  EXPECT_EQ(lost.size(), 34U);
  EXPECT_EQ(FaultOf(tree, boxes), "");
  EXPECT_FALSE(tree.Contains(99));
  EXPECT_TRUE(tree.Contains(98));
}

TEST(DbvtTree, StaysValidIfAllBoxesCoincideOrFormARow) {
  const Aabb box{{1, 2, 3}, {4, 5, 6}};
  std::vector<Aabb> boxes(3000, box);
  for (const float step : {0.0F, 1.0F}) {
    for (size_t object = 0; object < boxes.size(); ++object) {
      boxes[object].max[0] = 4 + step * static_cast<float>(object);
    }
    DbvtTree tree;
    BuildOf(tree, boxes, {});
    for (uint32_t object = 0; object < 3000; ++object) tree.Insert(object, boxes[object]);
    TreeInspection inspection(tree, boxes);
    EXPECT_EQ(inspection.Fault(), "");
    EXPECT_LE(inspection.leaf_count(), 3000U / 8) << "a split leaves eight objects in each leaf";
  }
}

TEST(DbvtTree, AcceptsTheLargestFloats) {
  constexpr float kLargest = 3.4028235e38F;
  std::vector<Aabb> boxes;
  for (int k = 0; k < 64; ++k) {
    const float side = k % 2 == 0 ? kLargest : 1;
    boxes.push_back({{-side, -side, -side}, {side, side, side}});
  }
  HookedVector<uint32_t> lost;
  DbvtTree tree;
  BuildOf(tree, boxes, {});
  for (uint32_t object = 0; object < 64; ++object) tree.Insert(object, boxes[object]);
  EXPECT_EQ(FaultOf(tree, boxes), "");
  tree.Refit(boxes, 1, nullptr, lost);
  tree.Settle();
  EXPECT_EQ(FaultOf(tree, boxes), "");
}

TEST(DbvtQuery, FindsEachPairOfTheListedObjectsOnce) {
  SequentialRandom random(4);
  const std::vector<Aabb> boxes = RandomBoxes(random, 200);
  DbvtTree tree;
  BuildOf(tree, boxes, FirstNumbers(200));
  std::vector<uint32_t> listed;
  std::vector<uint8_t> is_listed(200, 0);
  for (uint32_t object = 0; object < 200; object += 3) {
    listed.push_back(object);
    is_listed[object] = 1;
  }
  std::vector<OverlapPair> expected = ScalarPairs(boxes);
  std::erase_if(expected,
                [](const OverlapPair& pair) { return pair.a % 3 != 0 && pair.b % 3 != 0; });
  PairBuffer pairs;
  FindPairsOf(tree, listed, boxes.data(), is_listed.data(), pairs, nullptr);
  EXPECT_EQ(PairDifference(pairs.pairs(), expected), "");
}

TEST(Dbvt, SearchesNoTreeWhileBoxesStayInsideTheirMargins) {
  const auto backend = MakeOrThrow("DBVT");
  BoxScene scene("brownian", 1000, 8);
  PairBuffer pairs;
  backend->Build(scene.boxes());
  for (int frame = 0; frame < 4; ++frame) {
    pairs.Clear();
    backend->Update(scene.boxes());
    backend->FindPairs(pairs);
  }
  // Each enlarged box and each candidate is checked once. There are only a few more candidates than
  // pairs.
  EXPECT_LE(backend->aabb_check_count(), 1000 + 2 * pairs.size());
}

// Moves every `stride`-th of 2,000 boxes and returns the number of checks.
uint64_t ChecksWhenSomeMove(size_t stride) {
  const auto backend = MakeOrThrow("DBVT");
  SequentialRandom random(3);
  const BoxScene scene("brownian", 2000, 8);
  std::vector<Aabb> boxes(scene.boxes().begin(), scene.boxes().end());
  backend->Build(boxes);
  PairBuffer pairs;
  for (int frame = 0; frame < 12; ++frame) {
    for (size_t object = 0; object < boxes.size(); object += stride) {
      const float step = random.Between(-0.1F, 0.1F);
      boxes[object].min[0] += step;
      boxes[object].max[0] += step;
    }
    backend->Update(boxes);
    pairs.Clear();
    backend->FindPairs(pairs);
  }
  EXPECT_EQ(PairDifference(pairs.pairs(), ScalarPairs(boxes)), "");
  return backend->aabb_check_count();
}

TEST(Dbvt, MakesFewerChecksTheFewerBoxesMove) {
  const uint64_t all = ChecksWhenSomeMove(1);
  const uint64_t some = ChecksWhenSomeMove(100);
  EXPECT_LT(some * 8, all);
  EXPECT_LE(ChecksWhenSomeMove(2000), some);
}

TEST(Dbvt, FindsAllPairsThroughRestAndMotion) {
  const auto backend = MakeOrThrow("DBVT");
  BoxScene lively("brownian", 400, 8);
  BoxScene broken("broken-boxes", 400, 8);
  backend->Build(lively.boxes());
  PairBuffer pairs;
  std::vector<Aabb> boxes;
  for (int frame = 0; frame < 200; ++frame) {
    if (frame % 20 < 5) lively.Step();
    if (frame % 50 == 30) broken.Step();
    boxes.assign(lively.boxes().begin(), lively.boxes().end());
    // Some objects are added, removed or become invalid while the others rest.
    if (frame % 50 > 30) std::copy_n(broken.boxes().begin(), 10, boxes.begin());
    // Then a swarm moves through the others.
    for (size_t object = 20; object < 28; ++object) {
      const float way =
          (0.1F + 0.01F * static_cast<float>(object)) * static_cast<float>(frame % 20);
      boxes[object] = lively.boxes()[20];
      boxes[object].min[0] += way;
      boxes[object].max[0] += way;
    }
    boxes.resize(400 - static_cast<size_t>(frame % 7));
    backend->Update(boxes);
    ASSERT_EQ(FindPairsError(*backend, boxes, pairs), "") << "in frame " << frame;
  }
}

TEST(Dbvt, FindsNoPairsOfWhichOnlyTheMarginsOverlap) {
  const auto backend = MakeOrThrow("DBVT");
  PairBuffer pairs;
  std::vector<Aabb> boxes = {{{0, 0, 0}, {1, 1, 1}}, {{1.001F, 0, 0}, {2, 1, 1}}};
  backend->Build(boxes);
  EXPECT_EQ(FindPairsError(*backend, boxes, pairs), "");
  EXPECT_TRUE(pairs.empty());
  boxes[1].min[0] = 1;
  backend->Update(boxes);
  EXPECT_EQ(FindPairsError(*backend, boxes, pairs), "");
  EXPECT_EQ(pairs.size(), 1U);
}

}  // namespace
}  // namespace sweepstake
