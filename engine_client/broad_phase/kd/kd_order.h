// An order of boxes in which neighbours in space stand together: recursive splits at the median of
// the axis on which the centers are spread widest, measured in mean extents of the boxes.
//
// Boxes much larger than the room that sixteen boxes have are ordered among themselves, behind the
// others: by how large (steps of 4), and by which axes they are long on. Any of them would give
// its own bounds to the fifteen it stands with; those that are long on one axis only stand
// together with others long on that axis.
//
// Not thread-safe. Owns its memory. Cost: O(n log n), about 12 ns per box at 10,000, 30 at
// 1,000,000 (suite-b). Memory: 32 bytes per box.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/common/aligned_buffer.h"
#include "engine_client/broad_phase/common/box_groups.h"
#include "engine_client/broad_phase/common/soa_boxes.h"
#include "engine_client/broad_phase/kd/kd_split.h"
#include "engine_client/broad_phase/kd/size_classes.h"
#include "sweepstake/aabb.h"
#include "sweepstake/executor.h"

namespace sweepstake {

class KdOrder {
 public:
  // Splits end at parts of this many boxes. Larger parts are split at the multiple of 16, 256, 4096
  // … boxes nearest to the median, so that aligned runs of as many boxes never straddle a split.
  static constexpr uint32_t kPart = KdRange::kPart;

  // A slot without a box: no index.
  static constexpr uint32_t kHole = 0xFFFFFFFF;

  // Rearranges `order`, which names boxes by index, each at most once. Boxes that do not take part
  // go to the end.
  void Sort(std::span<const Aabb> boxes, std::span<uint32_t> order);

  // The same in steps, for `box_count` boxes in groups, where slots with id kHole are left out:
  // Begin takes their centers, each Advance moves about `budget` centers once and returns whether
  // all is done, and TakeSlots has the result. The groups need not stay. With an executor Finish
  // works in parts; the result is the same.
  void Begin(const BoxGroups& groups, size_t box_count);
  // Likewise for boxes that stand in no groups, all of them.
  void Begin(std::span<const Aabb> boxes);
  bool Advance(size_t budget);
  void Finish(Executor* executor);
  size_t box_count() const { return present_count_ + absent_count_; }
  // How often centers have to be moved in all.
  size_t work() const;
  // The boxes in their order, with holes where others begin at the next part. REQUIRES: all is
  // done; as many slots as slot_count().
  size_t slot_count() const;
  static constexpr size_t MostSlots(size_t box_count) {
    return box_count + (SizeClasses::kCount + 1) * kPart;
  }
  void TakeSlots(std::span<uint32_t> slots) const;

  size_t native_bytes() const {
    return floats_.capacity_bytes() + words_.capacity_bytes() + boxes_.native_bytes();
  }

 private:
  // Each split leaves at most 15/16 of a range.
  static constexpr size_t kStackSize = 512 + SizeClasses::kCount;

  struct Waiting {
    KdRange range;
    size_t columns;  // the ones that hold its centers
  };
  struct Run {
    size_t begin;
    size_t end;
  };

  void Reserve(size_t count);
  void StartSplitting();
  void CollectAbsent(const BoxGroups& groups, size_t box_count);
  void FormRuns();
  void MoveToClasses(std::span<const uint32_t> of_slots,
                     std::span<const size_t, SizeClasses::kCount> counts, double negligible);
  void PushRun(const KdRange& range, size_t columns);
  void SplitWhole(const Waiting& waiting);
  void SplitTop(const Waiting& waiting);

  SoaBoxes boxes_;                 // of Sort
  AlignedBuffer<float> floats_;    // of both columns
  AlignedBuffer<uint32_t> words_;  // of both columns, and the result
  KdColumns columns_[2] = {};
  // Boxes by slot, each class from a multiple of kPart on; from the end downwards those that do not
  // take part.
  uint32_t* result_ = nullptr;
  size_t capacity_ = 0;  // of each column, in slots
  size_t present_count_ = 0;
  size_t absent_count_ = 0;
  std::array<Run, SizeClasses::kCount> runs_;
  size_t run_count_ = 0;
  std::array<Waiting, kStackSize> stack_;
  size_t waiting_ = 0;
  size_t whole_range_ = 0;  // up to here a range is split down in one go
};

}  // namespace sweepstake
