// Tests the parts that only KDTree has: the order, the implicit tree over it, and how long the
// order is kept.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

#include "engine_client/broad_phase/common/box_record.h"
#include "engine_client/broad_phase/kd/kd_order.h"
#include "engine_client/broad_phase/kd/leaf_tree.h"
#include "engine_client/scene/box_scenes.h"
#include "tests/engine_client/broad_phase/backend_under_test.h"

namespace sweepstake {
namespace {

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

TEST(KdOrder, PutsInvalidBoxesLast) {
  const BoxScene scene("broken-boxes", 500, 3);
  std::vector<uint32_t> order = Identity(500);
  KdOrder splitter;
  splitter.Sort(scene.boxes(), order);
  EXPECT_TRUE(std::is_partitioned(order.begin(), order.end(),
                                  [&](uint32_t i) { return IsValid(scene.boxes()[i]); }));
}

TEST(KdOrder, SortsALineOfBoxes) {
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

TEST(KdOrder, CoincidentBoxesCanBeSortedRepeatedly) {
  const BoxScene scene("all-coincident", 1000, 3);
  std::vector<uint32_t> order = Identity(1000);
  KdOrder splitter;
  for (int round = 0; round < 3; ++round) splitter.Sort(scene.boxes(), order);
  std::sort(order.begin(), order.end());
  EXPECT_EQ(order, Identity(1000));
}

// Returns a tree in which slot k has box k.
LeafTree TreeOf(std::span<const Aabb> boxes) {
  LeafTree tree;
  tree.Refit(boxes, Identity(boxes.size()), nullptr);
  return tree;
}

// Returns the order of these boxes as slots, including empty slots.
template <typename Split>
std::vector<uint32_t> SlotsOf(std::span<const Aabb> boxes, const Split& split) {
  const LeafTree tree = TreeOf(boxes);
  KdOrder splitter;
  splitter.Begin(tree.leaves(), boxes.size());
  split(splitter);
  std::vector<uint32_t> slots(splitter.slot_count());
  splitter.TakeSlots(slots);
  return slots;
}
std::vector<uint32_t> SlotsOf(std::span<const Aabb> boxes) {
  return SlotsOf(boxes, [](KdOrder& splitter) { splitter.Finish(nullptr); });
}

float Center(const Aabb& box, int axis) { return box.min[axis] * 0.5F + box.max[axis] * 0.5F; }

// Returns whether there is an axis on which no center of the first `middle` slots is greater than a
// center of the other slots.
bool IsDivided(std::span<const Aabb> boxes, std::span<const uint32_t> slots, size_t middle) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto below = [&](uint32_t a, uint32_t b) {
      return Center(boxes[a], axis) < Center(boxes[b], axis);
    };
    const auto max = std::ranges::max_element(slots.first(middle), below);
    const auto min = std::ranges::min_element(slots.subspan(middle), below);
    if (!below(*min, *max)) return true;
  }
  return false;
}

void ExpectDivided(std::span<const Aabb> boxes, std::span<const uint32_t> slots) {
  if (slots.size() <= KdOrder::kPart) return;
  const size_t middle = KdSplitPoint({0, slots.size(), {}});
  ASSERT_TRUE(IsDivided(boxes, slots, middle)) << slots.size() << " slots, split at " << middle;
  ExpectDivided(boxes, slots.first(middle));
  ExpectDivided(boxes, slots.subspan(middle));
}

TEST(KdOrder, SplitsEveryPartAtTheMiddleOfAnAxis) {
  for (const std::string_view kind : {"brownian", "clusters", "touching-faces", "zero-size",
                                      "all-coincident", "planar", "coordinates-1e30"}) {
    for (const size_t count : {17, 100, 300, 1000, 5000, 20'000}) {
      const BoxScene scene(kind, count, 8);
      const std::vector<uint32_t> slots = SlotsOf(scene.boxes());
      if (std::ranges::find(slots, KdOrder::kHole) != slots.end())
        continue;  // skips boxes of several classes
      SCOPED_TRACE(kind);
      ExpectDivided(scene.boxes(), slots);
    }
  }
}

TEST(KdOrder, IsTheSameInStepsAndOnSeveralThreads) {
  const auto pool = MakeThreadPool(3);
  for (const std::string_view kind : {"brownian", "long-thin", "broken-boxes", "clusters"}) {
    const BoxScene scene(kind, 20'000, 8);
    const std::vector<uint32_t> at_once = SlotsOf(scene.boxes());
    int steps = 1;
    EXPECT_EQ(SlotsOf(scene.boxes(),
                      [&](KdOrder& splitter) {
                        for (; !splitter.Advance(splitter.work() / 7); ++steps) {
                        }
                      }),
              at_once);
    EXPECT_GE(steps, 4);
    EXPECT_LE(steps, 8);
    EXPECT_EQ(SlotsOf(scene.boxes(), [&](KdOrder& splitter) { splitter.Finish(pool.get()); }),
              at_once);
  }
}

TEST(KdOrder, ContainsEveryBox) {
  for (const std::string_view name : SceneNames(SceneGroup::kDegenerate)) {
    const auto scene = MakeDegenerateScene(name, 3000, 8);
    const auto count = static_cast<uint32_t>(scene->aabbs().size());
    std::vector<uint32_t> slots = SlotsOf(scene->aabbs());
    EXPECT_LE(slots.size(), KdOrder::MaxSlots(count));
    std::erase(slots, KdOrder::kHole);
    std::sort(slots.begin(), slots.end());
    EXPECT_EQ(slots, Identity(count)) << name;
  }
}

TEST(KdOrder, SeparatesLongBoxesByTheirAxis) {
  const BoxScene scene("long-thin", 3000, 8);
  const std::vector<uint32_t> slots = SlotsOf(scene.boxes());
  const auto long_axis = [&](const Aabb& box) {
    int longest = 0;
    for (int axis = 1; axis < 3; ++axis) {
      if (box.max[axis] - box.min[axis] > box.max[longest] - box.min[longest]) longest = axis;
    }
    return longest;
  };
  size_t mixed_leaves = 0;
  for (size_t first = 0; first + 16 <= slots.size(); first += 16) {
    int axes = 0;
    for (size_t slot = first; slot < first + 16; ++slot) {
      if (slots[slot] != KdOrder::kHole) axes |= 1 << long_axis(scene.boxes()[slots[slot]]);
    }
    mixed_leaves += (axes & (axes - 1)) != 0 ? 1 : 0;
  }
  EXPECT_LE(mixed_leaves, 2U);
}

TEST(KdOrder, IsTheSameFromLeavesBoxesAndAList) {
  for (const std::string_view kind : {"brownian", "long-thin", "broken-boxes"}) {
    const BoxScene scene(kind, 1000, 8);
    const std::vector<uint32_t> slots = SlotsOf(scene.boxes());
    KdOrder splitter;
    splitter.Begin(scene.boxes());
    splitter.Finish(nullptr);
    std::vector<uint32_t> from_boxes(splitter.slot_count());
    splitter.TakeSlots(from_boxes);
    EXPECT_EQ(from_boxes, slots) << kind;
    std::vector<uint32_t> list = Identity(1000);
    splitter.Sort(scene.boxes(), list);
    std::erase(from_boxes, KdOrder::kHole);
    EXPECT_EQ(list, from_boxes) << kind;
  }
}

// Returns the bounds of the valid boxes in `boxes`. Without a valid box, min is +inf and max −inf.
Aabb BoundsOf(std::span<const Aabb> boxes) {
  Aabb bounds{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  for (const Aabb& box : boxes) {
    if (!IsValid(box)) continue;
    for (int axis = 0; axis < 3; ++axis) {
      bounds.min[axis] = std::min(bounds.min[axis], box.min[axis]);
      bounds.max[axis] = std::max(bounds.max[axis], box.max[axis]);
    }
  }
  return bounds;
}

Aabb NodeAt(const BoxLanes& lanes, size_t node) {
  return {{lanes.min[0][node], lanes.min[1][node], lanes.min[2][node]},
          {lanes.max[0][node], lanes.max[1][node], lanes.max[2][node]}};
}

TEST(LeafTree, EachNodeHasTheExactBoundsOfItsBoxes) {
  for (const std::string_view kind : {"mixture", "broken-boxes"}) {
    const BoxScene scene(kind, 5000, 5);
    const LeafTree tree = TreeOf(scene.boxes());
    ASSERT_EQ(tree.view().top, 3U);
    size_t width = 1;
    for (size_t level = 1; level <= tree.view().top; ++level) {
      width *= LeafTree::kWidth;
      const BoxLanes& lanes = tree.view().levels[level];
      ASSERT_EQ(lanes.count, (5000 + width - 1) / width);
      for (size_t node = 0; node < lanes.count; ++node) {
        const size_t first = node * width;
        const auto below = scene.boxes().subspan(first, std::min(width, 5000 - first));
        ASSERT_EQ(NodeAt(lanes, node), BoundsOf(below)) << kind << ", level " << level;
      }
    }
  }
}

TEST(LeafTree, IsTheSameOnSeveralThreads) {
  const auto pool = MakeThreadPool(3);
  const BoxScene scene("broken-boxes", 20'000, 5);
  const LeafTree alone = TreeOf(scene.boxes());
  LeafTree in_parts;
  in_parts.Refit(scene.boxes(), Identity(20'000), pool.get());
  for (size_t level = 1; level <= alone.view().top; ++level) {
    for (size_t node = 0; node < alone.view().levels[level].count; ++node) {
      ASSERT_EQ(NodeAt(in_parts.view().levels[level], node),
                NodeAt(alone.view().levels[level], node));
    }
  }
}

TEST(LeafTree, FindsAllPairsInAnyOrder) {
  const BoxScene scene("brownian", 1000, 5);
  const LeafTree tree = TreeOf(scene.boxes());  // unordered: slow, but correct
  PairBuffer pairs;
  tree.FindPairs(0, tree.block_count(), pairs);
  EXPECT_EQ(PairDifference(pairs.pairs(), ScalarPairs(scene.boxes())), "");
}

TEST(LeafTree, FindsTheSamePairsInParts) {
  const BoxScene scene("clusters", 3000, 5);
  const LeafTree tree = TreeOf(scene.boxes());
  PairBuffer whole;
  PairBuffer parts;
  ASSERT_EQ(tree.block_count(), 12U);
  tree.FindPairs(0, 12, whole);
  tree.FindPairs(0, 5, parts);
  tree.FindPairs(5, 6, parts);
  tree.FindPairs(6, 12, parts);
  EXPECT_TRUE(std::ranges::equal(whole.pairs(), parts.pairs()));
}

// Returns the number of checks in each frame.
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

TEST(KdTree, SplitsAgainBeforeMotionTriplesTheChecks) {
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
  // A frame with clearly fewer checks than the previous frame indicates a split.
  int splits = 0;
  for (size_t i = 1; i < checks.size(); ++i) splits += checks[i] * 100 < checks[i - 1] * 95 ? 1 : 0;
  EXPECT_GE(splits, 2);
  EXPECT_LE(splits, 30);
}

TEST(KdTree, NeverSplitsASceneAtRestAgain) {
  const auto backend = MakeOrThrow("KDTree");
  const BoxScene scene("brownian", 3000, 5);
  PairBuffer first;
  backend->Build(scene.boxes());
  backend->FindPairs(first);
  for (int frame = 0; frame < 100; ++frame) {
    PairBuffer pairs;
    backend->Update(scene.boxes());
    backend->FindPairs(pairs);
    // Equal pairs in equal order imply an unchanged order of the boxes.
    ASSERT_TRUE(std::ranges::equal(pairs.pairs(), first.pairs()));
  }
}

// Every box has a new position in each frame.
TEST(KdTree, SplitsAtOnceIfTheOrderIsUseless) {
  const auto backend = MakeOrThrow("KDTree");
  backend->Build(BoxScene("brownian", 3000, 99).boxes());
  PairBuffer pairs;
  for (uint64_t frame = 0; frame < 5; ++frame) {
    const BoxScene scene("brownian", 3000, frame);
    pairs.Clear();
    backend->Update(scene.boxes());
    backend->FindPairs(pairs);
    EXPECT_LE(backend->aabb_check_count(), ChecksOfFreshBuild(scene) * 5 / 4);
  }
}

TEST(KdTree, NewBoxesKeepTheOrderOfTheOthers) {
  const auto backend = MakeOrThrow("KDTree");
  const BoxScene scene("brownian", 3000, 5);
  backend->Build(scene.boxes().first(2900));
  PairBuffer pairs;
  for (size_t count = 2900; count <= 3000; count += 10) {
    pairs.Clear();
    backend->Update(scene.boxes().first(count));
    backend->FindPairs(pairs);
    EXPECT_EQ(PairDifference(pairs.pairs(), ScalarPairs(scene.boxes().first(count))), "");
    EXPECT_LE(backend->aabb_check_count(), 2 * ChecksOfFreshBuild(scene));
  }
}

TEST(KdTree, FindsAllPairsIfTheCountChangesDuringASplit) {
  const auto backend = MakeOrThrow("KDTree");
  BoxScene scene("brownian", 800, 5);
  backend->Build(scene.boxes());
  PairBuffer pairs;
  SequentialRandom random(4);
  for (int frame = 0; frame < 300; ++frame) {
    scene.Step();
    const auto boxes = scene.boxes().first(760 + random.Below(41));
    pairs.Clear();
    backend->Update(boxes);
    backend->FindPairs(pairs);
    ASSERT_EQ(PairDifference(pairs.pairs(), ScalarPairs(boxes)), "") << "in frame " << frame;
  }
}

}  // namespace
}  // namespace sweepstake
