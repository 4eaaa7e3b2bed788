// A dynamic bounding volume tree, sixteen wide. A leaf holds up to sixteen objects, an inner node
// up to sixteen nodes. Each lane of a node holds one of these entries and its box.
//
// All leaves have the same depth. The size of a box is the sum of its sides, which works for flat
// and thin boxes too. An object is inserted where it enlarges the tree least. A node that overflows
// is split in two at the median of its widest axis. A node with fewer than kMinFill entries is
// removed, and its entries are inserted elsewhere.
//
// Each node has a reach, the size up to which it may stretch while its entries move: kReachFactor
// times the smallest size it has had. Refit reads the objects' new boxes. It removes objects and
// subtrees that enlarge a node beyond its reach and inserts them where they fit better. This is the
// forced reinsertion of the R*-tree (Beckmann et al. 1990), triggered by motion instead of
// insertion.
//
// Not thread-safe. Owns its memory. Boxes must be valid (aabb.h) unless a comment says otherwise.
// Cost: Build and Refit O(objects); Insert, Remove, Move and each entry that Refit moves elsewhere
// O(levels). Memory: 512 bytes per node, about 57 per object.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/common/aligned_buffer.h"
#include "engine_client/broad_phase/host/hook_points.h"
#include "sweepstake/aabb.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/executor.h"

namespace sweepstake {

// The minimum number of groups (lowest inner nodes) per part (some 1,500 objects) of a parallel
// loop. A smaller part takes less time than waking a thread.
inline constexpr size_t kMinGroupsPerPart = 8;

// A node. Lanes without an entry hold sentinels, which overlap nothing (min = +inf, max = -inf).
struct alignas(64) DbvtNode {
  static constexpr uint32_t kWidth = 16;

  float min[3][kWidth];
  float max[3][kWidth];
  uint32_t child[kWidth];  // the objects of a leaf, the nodes of an inner node
  float reach[kWidth];     // the size up to which each child node may grow
};
static_assert(sizeof(DbvtNode) == 512);

// The place of a node in the tree, and the number of its entries.
struct DbvtLink {
  uint32_t parent;
  uint8_t lane;
  uint8_t count;
  uint8_t level;  // 0 is a leaf
};

// The result of Refit for one group. A group is a lowest inner node with the leaves below it. Bit k
// stands for the leaf in lane k.
struct DbvtGroupNote {
  uint16_t stretched;  // the leaves that have grown beyond their reach
  uint16_t invalid;    // the leaves with invalid boxes
  // The motion of one object per leaf. `fast_count` is the number of these samples above Refit's
  // `step`, and `motion` is the sum of all samples, each limited to `step`.
  uint16_t fast_count;
  float motion;
};

class DbvtTree {
 public:
  static constexpr uint32_t kNone = 0xFFFFFFFF;
  static constexpr uint32_t kWidth = DbvtNode::kWidth;
  static constexpr uint32_t kMinFill = 4;
  // 16 levels hold 4^16 entries, if each node has kMinFill; one more level is for a root that is
  // not full.
  static constexpr size_t kMaxLevels = 17;
  static constexpr float kReachFactor = 1.35F;

  // Discards everything and inserts the objects in `slots`; each sixteen consecutive slots become a
  // leaf. An entry that is kNone or not an index of `boxes` leaves its lane empty. Objects with
  // invalid boxes are appended to `lost`. Afterwards the tree can hold objects 0 … boxes.size() −
  // 1. Polls `stop`, which may be null; after a stop the tree is undefined.
  void Build(std::span<const Aabb> boxes, std::span<const uint32_t> slots, Executor* executor,
             HookedVector<uint32_t>& lost, StopRequest* stop = nullptr);
  // Sets the number of objects that the tree can hold. REQUIRES: the tree holds no object from
  // `object_count` on.
  void Resize(size_t object_count);

  // REQUIRES: the object is not in the tree.
  void Insert(uint32_t object, const Aabb& box);
  // REQUIRES: the object is in the tree.
  void Remove(uint32_t object);
  // Changes the object's box. Moves the object to another leaf if its leaf would grow beyond its
  // reach. REQUIRES: the object is in the tree.
  void Move(uint32_t object, const Aabb& box);

  struct Motion {
    size_t sample_count;
    size_t fast_count;  // the number of samples above Refit's `step`
    float mean;         // the mean of the samples, each limited to `step`
    bool needs_build;
  };
  // Reads the objects' new boxes. Objects whose boxes have become invalid leave the tree and are
  // appended to `lost`. Entries that enlarge their node beyond its reach are removed from it and
  // wait until Settle or Build inserts them again; a search before that would miss them. If more
  // than half of the leaves have grown beyond their reach, needs_build is set and the next call
  // must be Build.
  Motion Refit(std::span<const Aabb> boxes, float step, Executor* executor,
               HookedVector<uint32_t>& lost);
  // Reads the objects' new boxes, but moves no object to another leaf. REQUIRES: the boxes of all
  // objects in the tree are valid.
  void TakeBoxes(std::span<const Aabb> boxes, Executor* executor);
  size_t waiting_count() const { return waiting_.size(); }
  // Inserts the waiting entries. Polls `stop`, which may be null; after a stop the remaining
  // entries are lost.
  void Settle(StopRequest* stop = nullptr);

  bool Contains(uint32_t object) const { return slots_[object] != kNone; }
  size_t object_count() const { return object_count_; }
  // The root is always an inner node; it has no entries if the tree is empty.
  uint32_t root() const { return root_; }
  const DbvtNode* nodes() const { return nodes_.data(); }
  const DbvtLink* links() const { return links_.data(); }
  // Returns the lowest inner nodes in depth-first order.
  std::span<const uint32_t> Groups();
  size_t native_bytes() const;

 private:
  struct Entry {
    Aabb box;
    uint32_t child;
    uint32_t level;  // the level of the node that holds the entry
  };

  uint32_t AllocateNode(uint32_t level);
  void FreeNode(uint32_t node);
  void LinkChild(uint32_t node, uint32_t lane, uint32_t child);
  void SetLane(uint32_t node, uint32_t lane, const Entry& entry);
  void RemoveLane(uint32_t node, uint32_t lane);
  Entry EntryAt(uint32_t node, uint32_t lane) const;
  void EvictLane(uint32_t node, uint32_t lane);
  void RemoveNode(uint32_t node);
  void WriteBounds(uint32_t node);
  void TightenUpFrom(uint32_t node);
  bool FitsInReach(uint32_t node, const Aabb& box) const;
  void WidenUpFrom(uint32_t node, const Aabb& box);
  void EvictToReach(uint32_t node);
  void EvictBelow(uint32_t node, uint32_t stretched);
  void RemoveInvalid(uint32_t leaf, std::span<const Aabb> boxes, HookedVector<uint32_t>& lost);
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
  AlignedBuffer<uint32_t> slots_;  // each object's node * kWidth + lane, or kNone
  HookedVector<Entry> waiting_;
  HookedVector<uint32_t> inner_;   // the inner nodes, parents before children
  HookedVector<uint32_t> groups_;  // the lowest inner nodes
  HookedVector<DbvtGroupNote> notes_;
  size_t object_count_ = 0;
  size_t node_limit_ = 0;  // one more than the maximum node number
  uint32_t root_ = kNone;
  uint32_t free_ = kNone;        // the first free node; DbvtLink::parent is the next one
  bool is_order_known_ = false;  // whether inner_ and groups_ are up to date
};

}  // namespace sweepstake
