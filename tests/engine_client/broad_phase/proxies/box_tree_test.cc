// A BoxTree that changes member by member must give the same results as a tree of the current
// members.
#include "engine_client/broad_phase/proxies/box_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "engine_client/broad_phase/proxies/tree_walk.h"
#include "engine_client/scene/random.h"
#include "sweepstake/broad_phase.h"

namespace sweepstake {
namespace {

// A tree of random boxes with about one box per unit of volume; some are large or invalid.
class BoxTreeTest : public testing::Test {
 protected:
  Aabb RandomBox(float from, float to) {
    Aabb box;
    const float half = random_.Below(500) == 0 ? 9 : random_.Between(0.1F, 0.5F);
    for (size_t axis = 0; axis < 3; ++axis) {
      const float center = random_.Between(axis == 0 ? from : 0, axis == 0 ? to : world_);
      box.min[axis] = center - half;
      box.max[axis] = center + half;
    }
    if (random_.Below(300) == 0) box.min[1] = std::numeric_limits<float>::quiet_NaN();
    return box;
  }

  void Add(const Aabb& box) {
    if (free_.empty()) {
      free_.push_back(static_cast<uint32_t>(boxes_.size()));
      boxes_.emplace_back();
      slots_.push_back(0);
    }
    const uint32_t id = free_.back();
    free_.pop_back();
    boxes_[id] = box;
    members_.push_back(id);
    tree_.EnsureRoomFor(1);
    tree_.Add(id, slots_);
  }
  void Remove(size_t k) {
    tree_.Remove(slots_[members_[k]]);
    free_.push_back(members_[k]);
    members_[k] = members_.back();
    members_.pop_back();
  }
  void Move(size_t k, const Aabb& box) {
    boxes_[members_[k]] = box;
    tree_.Move(slots_[members_[k]]);
  }
  // Gives another id to the member, as if its proxy had moved to another row.
  void Rename(size_t k) {
    const auto id = static_cast<uint32_t>(boxes_.size());
    boxes_.push_back(boxes_[members_[k]]);
    slots_.push_back(slots_[members_[k]]);
    free_.push_back(members_[k]);
    members_[k] = id;
    tree_.Rename(slots_[id], id);
  }
  void AddSome(size_t count) {
    for (; count > 0; --count) Add(RandomBox(0, world_));
  }
  // Makes some changes of each kind, most of them scattered, some all in one place.
  void ChangeSome(size_t count) {
    const float from = random_.Below(3) == 0 ? random_.Between(0, 2 * world_) : 0;
    const float to = from == 0 ? world_ : from + 3;
    for (size_t k = random_.Below(count); k > 0; --k) Add(RandomBox(from, to));
    for (size_t k = random_.Below(count); k > 0; --k) Remove(random_.Below(members_.size()));
    for (size_t k = random_.Below(count); k > 0; --k) {
      const size_t member = random_.Below(members_.size());
      Aabb box = boxes_[members_[member]];
      for (size_t axis = 0; axis < 3; ++axis) box.max[axis] += random_.Between(0, 0.1F);
      Move(member, random_.Below(2) == 0 ? box : RandomBox(from, to));
    }
    for (size_t k = random_.Below(count); k > 0; --k) Rename(random_.Below(members_.size()));
  }
  void RemoveWithin(float from, float to) {
    for (size_t k = members_.size(); k-- > 0;) {
      const Aabb& box = boxes_[members_[k]];
      if (box.min[0] >= from && box.max[0] <= to) Remove(k);
    }
  }
  void Update(bool any_moved = false) { tree_.Update(boxes_, any_moved, splitter_, slots_); }

  // Expects every member in its slot and nowhere else, with its current box. Each node must have
  // the bounds of all boxes below it.
  void ExpectWhole() {
    ASSERT_EQ(tree_.count(), members_.size());
    const std::span<const LeafBlock> leaves = tree_.leaves().leaves();
    size_t count = 0;
    for (const LeafBlock& leaf : leaves) {
      for (const uint32_t id : leaf.id) count += id == KdOrder::kHole ? 0 : 1;
    }
    ASSERT_EQ(count, members_.size());
    for (const uint32_t id : members_) {
      const LeafBlock& leaf = leaves[slots_[id] / 16];
      const size_t lane = slots_[id] % 16;
      ASSERT_EQ(leaf.id[lane], id);
      if (!IsValid(boxes_[id])) continue;
      for (size_t axis = 0; axis < 3; ++axis) {
        ASSERT_EQ(leaf.min[axis][lane], boxes_[id].min[axis]);
        ASSERT_EQ(leaf.max[axis][lane], boxes_[id].max[axis]);
      }
    }
    for (size_t axis = 0; axis < 3; ++axis) ExpectBounds(axis);
  }
  void ExpectBounds(size_t axis) {
    const LeafTree::View& view = tree_.view();
    for (size_t level = 1; level <= view.top; ++level) {
      const BoxLanes& nodes = view.levels[level];
      for (size_t node = 0; node < nodes.count; ++node) {
        const float* min =
            level == 1 ? view.leaves[node].min[axis] : view.levels[level - 1].min[axis] + 16 * node;
        const float* max =
            level == 1 ? view.leaves[node].max[axis] : view.levels[level - 1].max[axis] + 16 * node;
        ASSERT_EQ(nodes.min[axis][node], *std::min_element(min, min + 16)) << "level " << level;
        ASSERT_EQ(nodes.max[axis][node], *std::max_element(max, max + 16)) << "level " << level;
      }
    }
  }

  std::vector<OverlapPair> Sorted(std::span<const OverlapPair> pairs) const {
    std::vector<OverlapPair> sorted;
    for (const OverlapPair& pair : pairs) {
      sorted.push_back({std::min(pair.a, pair.b), std::max(pair.a, pair.b)});
    }
    std::sort(sorted.begin(), sorted.end(), [](const OverlapPair& a, const OverlapPair& b) {
      return a.a < b.a || (a.a == b.a && a.b < b.b);
    });
    return sorted;
  }
  // Pairs and query results must equal those of brute force.
  void ExpectPairsAndQueries() {
    std::vector<Aabb> boxes(boxes_.size(), Aabb{{1, 1, 1}, {0, 0, 0}});
    for (const uint32_t id : members_) boxes[id] = boxes_[id];
    const auto backend = std::move(*MakeBroadPhase("BruteForce"));
    backend->Build(boxes);
    PairBuffer all;
    backend->FindPairs(all);
    PairBuffer found;
    tree_.leaves().FindPairs(0, tree_.leaves().block_count(), found);
    ASSERT_EQ(Sorted(found.pairs()), Sorted(all.pairs()));
    for (int query = 0; query < 20; ++query) {
      const Aabb box = RandomBox(0, 2 * world_);
      std::vector<uint32_t> ids;
      FindOverlapping(tree_.view(), box,
                      {[](void* to, const uint32_t* some, size_t count) {
                         auto& list = *static_cast<std::vector<uint32_t>*>(to);
                         list.insert(list.end(), some, some + count);
                       },
                       &ids});
      std::vector<uint32_t> expected;
      for (const uint32_t id : members_) {
        if (Overlap(boxes_[id], box)) expected.push_back(id);
      }
      std::sort(ids.begin(), ids.end());
      std::sort(expected.begin(), expected.end());
      ASSERT_EQ(ids, expected);
    }
  }

  float world_ = 17;
  SequentialRandom random_{11};
  std::vector<Aabb> boxes_;
  std::vector<uint32_t> slots_;
  std::vector<uint32_t> free_;
  std::vector<uint32_t> members_;
  KdOrder splitter_;
  BoxTree tree_;
};

TEST_F(BoxTreeTest, IsCorrectAfterChangesOfAFewMembers) {
  AddSome(5000);
  for (int frame = 0; frame < 300; ++frame) {
    ChangeSome(frame % 4 == 0 ? 300 : 8);
    Update();
    ExpectWhole();
    if (frame % 50 == 0) ExpectPairsAndQueries();
  }
}

TEST_F(BoxTreeTest, IsCorrectAfterAllMembersMayHaveMoved) {
  AddSome(3000);
  for (int frame = 0; frame < 100; ++frame) {
    ChangeSome(8);
    for (const uint32_t id : members_) boxes_[id].min[0] -= 0.01F;
    for (size_t k = 0; frame % 2 != 0 && k < members_.size(); ++k) Move(k, boxes_[members_[k]]);
    Update(frame % 2 == 0);
    ExpectWhole();
    if (frame % 25 == 0) ExpectPairsAndQueries();
  }
}

// Objects that arrive together get their own branches; branches of tiles that were removed are
// freed.
TEST_F(BoxTreeTest, IsCorrectWhileTilesAreAddedAndRemoved) {
  world_ = 30;
  AddSome(27'000);
  for (int tile = 0; tile < 24; ++tile) {
    const float from = static_cast<float>(tile % 12) * 5;
    for (int k = 0; k < 2600; ++k) Add(RandomBox(from, from + 3));
    Update();
    ExpectWhole();
    RemoveWithin(from, from + 3);
    Update();
    ExpectWhole();
    EXPECT_LE(tree_.leaves().leaves().size() * 16, 3 * tree_.count());
    if (tile % 12 == 5) ExpectPairsAndQueries();
  }
}

// A search reads ids from the tree, which must be right without another update.
TEST_F(BoxTreeTest, HasTheNewIdsOfMembersAtOnce) {
  AddSome(3000);
  Update();
  for (size_t k = 0; k < 300; ++k) Rename(7 * k);
  ExpectWhole();
  ExpectPairsAndQueries();
}

TEST_F(BoxTreeTest, FreesTheMemoryOfFormerMembers) {
  // Whether the tree is updated, and whether the memory is freed before the next update.
  for (const auto& [is_used, is_freed] : {std::pair{true, false}, {true, true}, {false, true}}) {
    AddSome(2000);
    if (is_used) Update();
    const size_t bytes = tree_.native_bytes();
    AddSome(50'000);
    if (is_used) Update();
    while (members_.size() > 2000) Remove(members_.size() - 1);
    EXPECT_GT(tree_.native_bytes(), 4 * bytes);
    is_freed ? tree_.FreeUnused(slots_) : Update();
    EXPECT_LE(tree_.native_bytes(), bytes + bytes / 10);
    Update();
    ExpectWhole();
    ExpectPairsAndQueries();
    while (!members_.empty()) Remove(0);
    tree_ = {};
  }
}

TEST_F(BoxTreeTest, IsCorrectWithFewMembersAndNone) {
  for (int frame = 0; frame < 400; ++frame) {
    AddSome(random_.Below(6));
    for (size_t k = random_.Below(8); k > 0 && !members_.empty(); --k) Remove(0);
    if (!members_.empty()) Move(0, RandomBox(0, world_));
    if (frame % 50 == 0) AddSome(700);
    if (frame % 50 == 25) RemoveWithin(-99, 99);
    Update();
    ExpectWhole();
  }
  while (!members_.empty()) Remove(0);
  Update();
  ExpectWhole();
}

}  // namespace
}  // namespace sweepstake
