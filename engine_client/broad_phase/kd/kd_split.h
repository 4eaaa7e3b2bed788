// Median splits of centers in columns: the kernel of KdOrder.
//
// A split finds two values of the axis that enclose the median, from a sample and a count; sends
// what is below the one and what is above the other to its side in a second set of columns, a
// register at a time; and does the same with the few in between. Centers of one side keep their
// order, so that the result does not depend on the width of a register.
//
// Thread-safe for ranges that share no slot. Cost: 0.5 ns per center and split.
#pragma once

#include <cstddef>
#include <cstdint>

namespace sweepstake {

struct KdColumns {
  float* center[3];
  uint32_t* box;
};

// A run of slots to be split. REQUIRES: `begin` is a multiple of kPart, and the slots from `end` to
// the next multiple are nobody else's.
struct KdRange {
  // Splits end at this many boxes.
  static constexpr size_t kPart = 16;

  size_t begin;
  size_t end;
  // Splits are across the axis of the greatest spread times this.
  float axis_weight[3];

  size_t count() const { return end - begin; }
};

// Strictly inside a range of more than kPart: the multiple of 16, 256, 4096 … slots, counted from
// its begin, that is nearest to the middle, so that aligned runs of as many slots never straddle a
// split.
size_t KdSplitPoint(const KdRange& range);

// Moves the slots of the range from `from` to the same ones of `to`, those up to the split point
// below the others. `from` is left in disorder. REQUIRES: more than kPart slots.
void SplitOnce(const KdColumns& from, const KdColumns& to, const KdRange& range);

// Splits until no part is larger than kPart, to and fro between the columns; `order` takes the
// boxes of the range's slots.
void SplitAll(const KdColumns& from, const KdColumns& to, const KdRange& range, uint32_t* order);

}  // namespace sweepstake
