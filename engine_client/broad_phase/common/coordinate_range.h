// The range that holds most boxes of a scene, estimated from a sample. Coordinates are quantised
// over this range. It also gives the axis along which a sweep compares the fewest boxes.
//
// Code that uses the range must stay correct for boxes outside it.
#pragma once

#include <algorithm>
#include <span>

#include "sweepstake/aabb.h"

namespace sweepstake {

// The range on each axis. Sample estimates it from at most 128 boxes, at a constant cost.
struct CoordinateRange {
  static constexpr float kMinWidth = 1e-30F;

  // The bounds and their difference are finite; low <= high.
  float low[3] = {0, 0, 0};
  float high[3] = {1, 1, 1};
  // The axis on which the boxes' extents are the smallest fraction of the range.
  int sweep_axis = 0;

  static CoordinateRange Sample(std::span<const Aabb> boxes);

  // Returns at least kMinWidth, so that a division by the result does not overflow.
  float width(int axis) const { return std::max(high[axis] - low[axis], kMinWidth); }
};

}  // namespace sweepstake
