// The range that holds most boxes of a scene, estimated from a sample; coordinates are quantised
// over it. Also the axis along which a sweep compares the fewest boxes.
//
// Correctness must not depend on the range: outliers lie outside it.
#pragma once

#include <algorithm>
#include <span>

#include "sweepstake/aabb.h"

namespace sweepstake {

// Sample reads at most 128 boxes, so that its cost does not depend on their number.
struct CoordinateRange {
  static constexpr float kMinWidth = 1e-30F;

  // Finite, low <= high, with a finite difference.
  float low[3] = {0, 0, 0};
  float high[3] = {1, 1, 1};
  // The axis on which the boxes' extents are the smallest fraction of the range.
  int sweep_axis = 0;

  static CoordinateRange Sample(std::span<const Aabb> boxes);

  // Returns at least kMinWidth, so that a quotient by it stays finite.
  float width(int axis) const { return std::max(high[axis] - low[axis], kMinWidth); }
};

}  // namespace sweepstake
