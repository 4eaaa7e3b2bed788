// The range that holds most boxes of a scene, estimated from a sample. Coordinates are quantised
// over this range. It also gives the axis along which a sweep compares the fewest boxes.
//
// Code that uses the range must stay correct for boxes outside it.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "engine_client/broad_phase/common/piecewise_line.h"
#include "sweepstake/aabb.h"

namespace sweepstake {

// Returns the index of the k-th box of a sample of the boxes. A fixed stride would be wrong, since
// the kind of an object often depends on its index modulo some number. REQUIRES: box_count > 0.
size_t DrawIndex(size_t k, size_t box_count);

// The range on each axis. Sample estimates it from at most 128 boxes, at a constant cost.
struct CoordinateRange {
  static constexpr float kMinWidth = 1e-30F;

  // The bounds and their difference are finite; low <= high.
  float low[3] = {0, 0, 0};
  float high[3] = {1, 1, 1};
  // A function that rises from 0 to 1 over the range. It replaces the straight line from `low`
  // to `high` where most boxes share a small part of the range; elsewhere it has no segments.
  static constexpr size_t kMaxSegments = 8;
  std::array<PiecewiseLine<kMaxSegments>, 3> lines;
  // The axis on which the boxes' extents are the smallest fraction of the range.
  int sweep_axis = 0;

  static CoordinateRange Sample(std::span<const Aabb> boxes);

  // Returns at least kMinWidth, so that a division by the result does not overflow.
  float width(int axis) const { return std::max(high[axis] - low[axis], kMinWidth); }
};

}  // namespace sweepstake
