// A dynamic bounding volume tree sixteen wide: leaves hold up to sixteen objects, inner nodes up to
// sixteen nodes, each with its box in a lane of its node.
//
// All leaves have one depth. An object is inserted where the tree grows least (by the sum of a
// box's sides, which serves flat and thin boxes too), a node that overflows is split in two at the
// median of its widest axis, and one with fewer than kLeastFill entries hands them to its
// neighbours. Each node has a reach: how large it may become while its entries move, kMargin times
// the smallest it was. Refit follows the objects and puts what stretches a node beyond its reach,
// objects and whole subtrees alike, to where it fits better: the R*-tree's forced reinsertion
// (Beckmann et al. 1990), asked for by motion.
//
// Not thread-safe. Owns its memory. Boxes must take part (aabb.h) where nothing else is said. Cost:
// Build 10 ns per object; Refit 1.7 ns per object and 0.2 us per entry that is moved; Insert and
// Remove 0.2 us (at 10,000 objects). Memory: 512 bytes per node, about 57 per object.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine_client/broad_phase/common/aligned_buffer.h"
#include "sweepstake/aabb.h"
#include "sweepstake/executor.h"

namespace sweepstake {

// Lanes from the count on hold boxes that overlap nothing (min = +inf, max = -inf).
struct alignas(64) DbvtNode {
  static constexpr uint32_t kWidth = 16;

  float min[3][kWidth];
  float max[3][kWidth];
  uint32_t child[kWidth];  // objects in a leaf, nodes elsewhere
  float reach[kWidth];     // of child nodes
};
static_assert(sizeof(DbvtNode) == 512);

// Where a node hangs, and how full it is.
struct DbvtLink {
  uint32_t parent;
  uint8_t lane;
  uint8_t count;
  uint8_t level;  // 0: a leaf
};

// What Refit saw below one lowest inner node; bit k speaks of its lane k.
struct DbvtGroupNote {
  uint16_t stretched;
  uint16_t broken;    // a leaf with boxes that do not take part
  uint16_t restless;  // sampled objects, one per leaf, that went further than a step
  float motion;       // sum of the samples' motion, each at most a step
};

class DbvtTree {
 public:
  static constexpr uint32_t kNone = 0xFFFFFFFF;
  static constexpr uint32_t kWidth = DbvtNode::kWidth;
  static constexpr uint32_t kLeastFill = 4;
  // 4^16 entries, and one for a root that is not full.
  static constexpr size_t kMaxLevels = 17;
  static constexpr float kMargin = 1.35F;

  // Discards all and takes the objects in `slots`, of which each sixteen become a leaf, in their
  // order; kNone and numbers that are no index of `boxes` leave a gap. Objects whose boxes do not
  // take part go to `lost`. Objects 0 … boxes.size() − 1 can be in the tree from now on.
  void Build(std::span<const Aabb> boxes, std::span<const uint32_t> slots, Executor* executor,
             std::vector<uint32_t>& lost);
  // Makes room for another number of objects. REQUIRES: those at and above it are not in the tree.
  void Resize(size_t object_count);

  // REQUIRES: the object is not in the tree.
  void Insert(uint32_t object, const Aabb& box);
  // REQUIRES: the object is in the tree.
  void Remove(uint32_t object);
  // Gives the object another box, and another place where that would stretch its leaf beyond its
  // reach. REQUIRES: as for Remove.
  void Move(uint32_t object, const Aabb& box);

  struct Motion {
    size_t sampled;
    size_t restless;  // of these, moved further than the step
    float mean;       // of the samples, each cut off at the step
    bool is_upheaval;
  };
  // Takes the objects' new boxes. Those that no longer take part leave the tree and go to `lost`;
  // what stretches its node too far leaves it and waits for Settle or Build. Searches before either
  // would miss it. An upheaval, where more than half of the leaves are stretched, asks for Build at
  // once.
  Motion Refit(std::span<const Aabb> boxes, float step, Executor* executor,
               std::vector<uint32_t>& lost);
  // Likewise, and everything stays where it is. REQUIRES: the boxes of all objects take part.
  void TakeBoxes(std::span<const Aabb> boxes, Executor* executor);
  size_t waiting_count() const { return waiting_.size(); }
  void Settle();

  bool Contains(uint32_t object) const { return slots_[object] != kNone; }
  size_t object_count() const { return object_count_; }
  // Never a leaf; without entries when the tree is empty.
  uint32_t root() const { return root_; }
  const DbvtNode* nodes() const { return nodes_.data(); }
  const DbvtLink* links() const { return links_.data(); }
  // Upper bound of node numbers.
  size_t node_limit() const { return node_limit_; }
  // The inner nodes above leaves, depth first.
  std::span<const uint32_t> Groups();
  size_t native_bytes() const;

 private:
  struct Entry {
    Aabb box;
    uint32_t child;
    uint32_t level;  // of the node it goes to
  };

  uint32_t AllocateNode(uint32_t level);
  void FreeNode(uint32_t node);
  void LinkChild(uint32_t node, uint32_t lane, uint32_t child);
  void SetLane(uint32_t node, uint32_t lane, const Entry& entry);
  void RemoveLane(uint32_t node, uint32_t lane);
  Entry EntryAt(uint32_t node, uint32_t lane) const;
  void EvictLane(uint32_t node, uint32_t lane);
  void Dissolve(uint32_t node);
  void WriteBounds(uint32_t node);
  void TightenUpFrom(uint32_t node);
  bool FitsInReach(uint32_t node, const Aabb& box) const;
  void WidenUpFrom(uint32_t node, const Aabb& box);
  void Shed(uint32_t node);
  void ShedBelow(uint32_t node, uint32_t stretched);
  void RemoveBroken(uint32_t leaf, std::span<const Aabb> boxes, std::vector<uint32_t>& lost);
  void Attach(const Entry& entry);
  void AddTo(uint32_t node, const Entry& entry);
  void Split(uint32_t node, const Entry& entry);
  void Reserve(size_t object_count);
  void BuildLeaf(std::span<const uint32_t> objects);
  void BuildLevel(uint32_t level, uint32_t first, uint32_t end);
  void CollectOrder();
  Motion SumUpNotes() const;
  void RefitGroups(std::span<const Aabb> boxes, float step, Executor* executor);

  AlignedBuffer<DbvtNode> nodes_;
  AlignedBuffer<DbvtLink> links_;
  AlignedBuffer<uint32_t> slots_;  // of each object: node * kWidth + lane
  std::vector<Entry> waiting_;
  std::vector<uint32_t> inner_;  // parents before children
  std::vector<uint32_t> groups_;
  std::vector<DbvtGroupNote> notes_;
  size_t object_count_ = 0;
  size_t node_limit_ = 0;
  uint32_t root_ = kNone;
  uint32_t free_ = kNone;  // list through DbvtLink::parent
  bool is_order_known_ = false;
};

}  // namespace sweepstake
