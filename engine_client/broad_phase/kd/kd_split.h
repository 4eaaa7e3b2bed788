// Median splits of centers in columns: the kernel of KdOrder.
//
// A split finds two values on the axis that enclose the median, from a sample and a count. It moves
// the centers below the lower value and above the upper value to their sides in a second set of
// columns, a register at a time. It repeats this with the few centers in between. The centers of
// one side keep their order, so that the result does not depend on the width of a register.
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
  // Ranges of up to this number of boxes (parts) are not split further.
  static constexpr size_t kPart = 16;

  size_t begin;
  size_t end;
  // A split uses the axis with the largest product of the centers' spread and this weight.
  float axis_weight[3];
  // Where possible, a split does not divide a run of this number of parts (KdSplitPoint).
  size_t run_parts = kPart;

  size_t count() const { return end - begin; }
};

// Returns the slot at which a range of more than kPart slots is split. The split is at a multiple
// of a block size, counted from `begin`, and as near to the middle as possible. Block sizes are one
// part, run_parts parts, 16 · run_parts parts and so on; the largest below the size of the range is
// used. Aligned runs of these sizes then stay undivided.
size_t KdSplitPoint(const KdRange& range);

// Moves the centers of the range from `from` to `to`, so that the centers before the split point
// are below the others on one axis. The content of `from` is then undefined. REQUIRES: more than
// kPart slots.
void SplitOnce(const KdColumns& from, const KdColumns& to, const KdRange& range);

// Splits recursively until no part is larger than kPart, moving centers back and forth between
// `from` and `to`. Writes the resulting boxes to the range's slots in `order`.
void SplitAll(const KdColumns& from, const KdColumns& to, const KdRange& range, uint32_t* order);

}  // namespace sweepstake
