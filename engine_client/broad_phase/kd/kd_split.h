// Median splits of centers in columns: the kernel of KdOrder.
//
// A split finds two values on the axis that enclose the median, from a sample and a count. It moves
// the centers below the lower value and above the upper value to their sides in a second set of
// columns, a register at a time. It repeats this with the few in between. The centers of one side
// keep their order, so that the result does not depend on the width of a register.
//
// Thread-safe for ranges that share no slot. Cost: O(centers) per split.
#pragma once

#include <cstddef>
#include <cstdint>

namespace sweepstake {

// Centers of boxes and the ids of the boxes, slot by slot.
struct KdColumns {
  float* center[3];
  uint32_t* box;
};

// A range of slots to be split. REQUIRES: `begin` is a multiple of kPart, and the slots from `end`
// to the next multiple are not in use.
struct KdRange {
  // Splits end at this many boxes.
  static constexpr size_t kPart = 16;

  size_t begin;
  size_t end;
  // A split uses the axis with the largest product of the centers' spread and this weight.
  float axis_weight[3];
  // Splits are at multiples of this many parts where possible.
  size_t run_parts = kPart;

  size_t count() const { return end - begin; }
};

// Returns the slot at which a range of more than kPart slots is split. Blocks are a part, run_parts
// parts, 16 times as many and so on. It takes the largest block smaller than the range, and the
// multiple of it, counted from `begin`, that is nearest to the middle. No split then cuts an
// aligned run of one of these sizes.
size_t KdSplitPoint(const KdRange& range);

// Moves the centers of the range from `from` to `to`, so that those before the split point are
// below the others on one axis. `from` is left in disorder. REQUIRES: more than kPart slots.
void SplitOnce(const KdColumns& from, const KdColumns& to, const KdRange& range);

// Splits until no part is larger than kPart, moving centers back and forth between the columns, and
// writes the boxes of the range's slots to `order`.
void SplitAll(const KdColumns& from, const KdColumns& to, const KdRange& range, uint32_t* order);

}  // namespace sweepstake
