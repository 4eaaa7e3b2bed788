// A dynamic bounding volume hierarchy: a binary tree over boxes that are inserted, moved and
// removed one by one.
//
// Nodes 0 … leaf_count − 1 are the leaves, by the index the caller knows them under; the inner
// nodes follow. Siblings are chosen by surface area (Goldsmith & Salmon 1987); rotations on the way
// up keep heights of siblings within one of each other where they can, and a tree that outgrows
// MaxHeight() all the same is split anew by medians, so that every walk over the tree fits a stack
// of kStackSize whatever the input, all boxes coincident included.
//
// Not thread-safe. Boxes must be finite. Memory: 41 bytes per node (two nodes per leaf) and 16 per
// leaf for rebuilding; kept until destruction. Cost: Insert, Move and Remove O(height); Rebuild O(n
// log n); Refit O(n).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "sweepstake/aabb.h"

namespace sweepstake {

// Two halves of a vector register each; the children sit in the lanes that the coordinates leave
// free.
struct alignas(32) DbvtNode {
  float min[3];
  uint32_t first;
  float max[3];
  uint32_t second;
};
static_assert(sizeof(DbvtNode) == 32);

class DbvtTree {
 public:
  static constexpr uint32_t kNone = 0xFFFFFFFF;
  // Nodes that wait at once on a depth-first walk which pushes both children: at most MaxHeight()
  // + 1.
  static constexpr size_t kStackSize = 128;

  // Forgets all boxes and makes room for leaves 0 … leaf_count − 1, none of them in the tree.
  void Reset(size_t leaf_count);

  // REQUIRES: `leaf` is not in the tree.
  void Insert(uint32_t leaf, const Aabb& box);
  // Gives the leaf another box and another place, sought from where it was. REQUIRES: `leaf` is in
  // the tree.
  void Move(uint32_t leaf, const Aabb& box);
  void Remove(uint32_t leaf);

  // Bulk changes: SetBox puts a box under a leaf without looking at the rest (adding the leaf if it
  // is not in the tree); the tree is valid again after Rebuild or, if no leaf was added, Refit.
  void SetBox(uint32_t leaf, const Aabb& box);
  void Rebuild();
  void Refit();

  bool Contains(uint32_t leaf) const { return present_[leaf] != 0; }
  bool IsLeaf(uint32_t node) const { return node < leaf_count_; }
  // kNone: the tree is empty.
  uint32_t root() const { return root_; }
  uint32_t parent(uint32_t node) const { return parents_[node]; }
  const DbvtNode* nodes() const { return nodes_.data(); }
  Aabb box(uint32_t node) const;
  size_t leaf_count() const { return leaf_count_; }
  // Leaves in the tree.
  size_t size() const { return size_; }
  uint32_t height() const { return root_ == kNone ? 0 : heights_[root_]; }
  uint32_t height(uint32_t node) const { return heights_[node]; }
  // Highest tree that is kept for this number of leaves: 2 log2(n) + 4.
  static uint32_t MaxHeight(size_t leaf_count);
  // Leaves in depth-first order, as of the latest Refit or Rebuild.
  const std::vector<uint32_t>& order() const { return order_; }
  size_t native_bytes() const;

 private:
  struct Center {
    float at[3];
    uint32_t leaf;
  };
  // A part of centers_ that becomes the subtree below one child link of `parent`.
  struct Range {
    uint32_t begin;
    uint32_t end;
    uint32_t parent;
    bool is_second;
  };

  uint32_t AllocateNode();
  void FreeNode(uint32_t node);
  void Attach(uint32_t leaf, uint32_t start);
  uint32_t Detach(uint32_t leaf);
  uint32_t ChooseSibling(const DbvtNode& box, uint32_t start) const;
  uint32_t LowestContaining(uint32_t node, const DbvtNode& box) const;
  void ReplaceChild(uint32_t parent, uint32_t old_child, uint32_t new_child);
  bool Pull(uint32_t node);
  uint32_t Rotate(uint32_t node);
  void PullUpFrom(uint32_t node);
  void BoundHeight();
  void CollectCenters();
  uint32_t SplitRange(const Range& range);
  void CollectOrder();

  std::vector<DbvtNode> nodes_;
  std::vector<uint32_t> parents_;
  std::vector<uint32_t> heights_;
  std::vector<uint8_t> present_;  // per leaf
  std::vector<Center> centers_;
  std::vector<uint32_t> order_;
  std::vector<uint32_t> inner_order_;  // inner nodes, parents before children
  size_t leaf_count_ = 0;
  size_t size_ = 0;
  uint32_t root_ = kNone;
  uint32_t free_ = kNone;     // list through DbvtNode::first
  uint32_t next_unused_ = 0;  // inner nodes from here on were never used
};

}  // namespace sweepstake
