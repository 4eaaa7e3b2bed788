// The measurements that a grid is planned from: the bounds of the boxes' min corners, and for each
// shape class the number of boxes and their maximum sides.
//
// Plain values. Cost: O(n); it is several times as high with boxes of several classes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/grid/group_grid.h"
#include "sweepstake/aabb.h"
#include "sweepstake/broad_phase.h"

namespace sweepstake {

// A shape class is a size step (0 to 3) for each axis. The box's side on the axis is at most the
// threshold, at most 4 times as long, at most 16 times as long, or longer.
struct ShapeClasses {
  static constexpr int kBitsPerAxis = 2;
  static constexpr uint32_t kCount = 64;
  static constexpr float kRatio = 4;

  // Half the length of a side up to which a box has size step 0 on that axis, in world units.
  float threshold;

  // Returns the size step of half the length of a side.
  uint32_t StepOf(float side) const {
    uint32_t step = 0;
    for (float limit = threshold; step < 3 && side > limit; limit *= kRatio) ++step;
    return step;
  }
};

struct GridMeasure {
  // The bounds of the min corners, with halved coordinates; low > high if no box is valid.
  float low[3];
  float high[3];
  std::array<GroupShape, ShapeClasses::kCount> shapes{};

  GridMeasure();
  // Adds the measurement of another set of boxes to this one.
  void Join(const GridMeasure& other);
  uint32_t count() const;
};

// Measures the valid boxes (aabb.h). Polls `stop`, which may be null; after a stop the remaining
// boxes are left out.
GridMeasure MeasureBoxes(std::span<const Aabb> boxes, const ShapeClasses& classes,
                         StopRequest* stop = nullptr);

}  // namespace sweepstake
