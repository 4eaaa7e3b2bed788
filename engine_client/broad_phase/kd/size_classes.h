// Which boxes are too large, or too long, to stand in one leaf with the others.
//
// A leaf of sixteen ordinary boxes is as wide as the room that sixteen boxes have. A box that
// clearly exceeds that width, and what is usual on that axis, is large; large boxes are told apart
// by the size of their longest side in steps of 4 and by the axes on which they are long.
//
// Thread-safe: plain values.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/kd/kd_centers.h"

namespace sweepstake {

class SizeClasses {
 public:
  static constexpr size_t kCount = 32;  // 0 is that of the ordinary boxes

  // For `count` boxes with these extents, axis by axis, and spreads. REQUIRES: count > 0.
  SizeClasses(const AxisSpread (&spreads)[3], const float* const (&extents)[3], size_t count);

  // No box is large.
  bool all_ordinary() const { return all_ordinary_; }
  size_t ClassOf(float extent0, float extent1, float extent2) const;
  // The classes of all boxes to `classes`; how many boxes each has. Cost: 2 ns per box.
  std::array<size_t, kCount> ClassifyAll(const float* const (&extents)[3],
                                         std::span<uint32_t> classes) const;

 private:
  float long_from_[3];
  float step_;  // the longest side of the smallest large boxes
  bool all_ordinary_ = true;
};

}  // namespace sweepstake
