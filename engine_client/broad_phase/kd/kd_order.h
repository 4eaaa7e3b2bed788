// An order of boxes that keeps neighbours in space together. It splits recursively at the median of
// the axis with the widest spread of centers, measured in mean extents of the boxes.
//
// Boxes much larger than an ordinary leaf are ordered separately, behind the others. They form
// classes by size and by the axes on which they are long (kd_centers.h). Any of them would widen a
// leaf of ordinary boxes to its own bounds.
//
// The work can be done at once (Finish) or spread over frames (Advance); the result is the same.
//
// Not thread-safe. Owns its memory. Cost: O(n log n). Memory: 36 bytes per box.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/common/aligned_buffer.h"
#include "engine_client/broad_phase/kd/kd_centers.h"
#include "engine_client/broad_phase/kd/kd_split.h"
#include "engine_client/broad_phase/kd/leaf_tree.h"
#include "sweepstake/aabb.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/executor.h"

namespace sweepstake {

class KdOrder {
 public:
  // A part is a range of up to this number of boxes. Parts are not split further.
  static constexpr uint32_t kPart = KdRange::kPart;

  // The entry of a slot without a box. It is not a valid index.
  static constexpr uint32_t kHole = 0xFFFFFFFF;

  // Begins a new order of the `box_count` boxes in these leaves; slots with id kHole are skipped.
  // The leaves are read during the call only.
  void Begin(std::span<const LeafBlock> leaves, size_t box_count);
  // Begins a new order of these boxes.
  void Begin(std::span<const Aabb> boxes);
  // Does a part of the remaining work, about `budget` moves of a center. Returns whether the order
  // is complete.
  bool Advance(size_t budget);
  // Does all remaining work, in parts if there is an executor. Returns false if `stop`, which may
  // be null, ended it; the order is then incomplete.
  bool Finish(Executor* executor, StopRequest* stop = nullptr);
  // Returns the work for the whole order, as the number of times that a center is moved.
  size_t work() const;
  size_t box_count() const { return valid_count_ + invalid_count_; }

  // Writes the boxes in their order, with holes so that each class begins at a multiple of kPart.
  // Invalid boxes are last. REQUIRES: the order is complete, slots.size() == slot_count().
  void TakeSlots(std::span<uint32_t> slots) const;
  // Returns the number of boxes plus the number of holes. REQUIRES: the order is complete.
  size_t slot_count() const;
  static constexpr size_t MaxSlots(size_t box_count) {
    return box_count + (SizeClasses::kCount + 1) * kPart;
  }
  // Writes the boxes in their order without holes. REQUIRES: the order is complete, order.size() ==
  // box_count().
  void TakeBoxes(std::span<uint32_t> order) const;

  // Orders only the boxes with the indices in `order`, each at most once, and rearranges `order`
  // unless stopped. Where possible, a split does not divide a run of `run_parts` · kPart boxes,
  // which becomes a block of a tree (KdSplitPoint).
  void Sort(std::span<const Aabb> boxes, std::span<uint32_t> order, StopRequest* stop = nullptr,
            size_t run_parts = kPart);

  size_t native_bytes() const { return floats_.capacity_bytes() + words_.capacity_bytes(); }

 private:
  // The maximum number of ranges on the stack. 512 are enough, since the larger side of a split has
  // at most 15/16 of its range.
  static constexpr size_t kStackSize = 512 + SizeClasses::kCount;

  // A range that is still to be split.
  struct Waiting {
    KdRange range;
    size_t columns;  // the index in columns_ of the columns that hold its centers
  };
  // The slots of one size class.
  struct Run {
    size_t begin;
    size_t end;
  };

  void Reserve(size_t count);
  void Collect(const Aabb& box, uint32_t index);
  void CollectInvalid(std::span<const LeafBlock> leaves);
  void StartSplitting();
  void FormRuns();
  void MoveToClasses(std::span<const uint32_t> of_slots,
                     std::span<const size_t, SizeClasses::kCount> counts, double negligible);
  void PushRun(const KdRange& range, size_t columns);
  void SplitWhole(const Waiting& waiting);
  void SplitTop(const Waiting& waiting);
  std::span<const uint32_t> InvalidBoxes() const {
    return {result_ + capacity_ - invalid_count_, invalid_count_};
  }

  AlignedBuffer<float> floats_;    // the centers of both sets of columns
  AlignedBuffer<uint32_t> words_;  // the boxes of both sets, and the result
  // The two sets of columns. A split moves centers from one set to the other.
  KdColumns columns_[2] = {};
  // The box of each slot. Each size class begins at a multiple of kPart; invalid boxes are at the
  // end.
  uint32_t* result_ = nullptr;
  size_t capacity_ = 0;  // the number of slots of each column
  size_t valid_count_ = 0;
  size_t invalid_count_ = 0;
  std::array<Run, SizeClasses::kCount> runs_;
  size_t run_count_ = 0;
  size_t run_parts_ = kPart;
  std::array<Waiting, kStackSize> stack_;
  size_t waiting_ = 0;
  // One step splits a range of up to this size down to parts (kPart).
  size_t whole_range_ = 0;
};

}  // namespace sweepstake
