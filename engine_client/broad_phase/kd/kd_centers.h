// Computes the values by which KdOrder splits: centers and extents of boxes, their spread, and
// which boxes are too large to share a leaf with ordinary ones.
//
// Thread-safe: works on its arguments only. Cost: O(n) each.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/kd/kd_split.h"
#include "engine_client/broad_phase/kd/leaf_tree.h"

namespace sweepstake {

// Writes the centers and ids of the valid boxes to `centers` and their extents to `extents`, in the
// order of the leaves. Returns their number. May write up to one register behind the last slot.
size_t CollectCenters(std::span<const LeafBlock> leaves, const KdColumns& centers,
                      const KdColumns& extents);

// The spread of boxes on one axis.
struct AxisSpread {
  float min_center;
  float max_center;
  float max_extent;
  double extent_sum;
};
// Returns the spread of `count` boxes. REQUIRES: count > 0.
AxisSpread SpreadOf(const float* centers, const float* extents, size_t count);

// Divides boxes into classes by size. The width of an ordinary leaf is estimated as the cube root
// of the volume per sixteen boxes. A box is large if, on any axis, it clearly exceeds that width
// and the usual extent. The class of a large box encodes its size (the longest side, in steps of
// factor 4) and the axes on which it is long.
class SizeClasses {
 public:
  static constexpr size_t kCount = 32;  // class 0 holds the ordinary boxes

  // Determines the classes from the spreads and the `count` extents of each axis. REQUIRES: count >
  // 0.
  SizeClasses(const AxisSpread (&spreads)[3], const float* const (&extents)[3], size_t count);

  bool all_ordinary() const { return all_ordinary_; }
  // Writes the class of each box to `classes`; returns the number of boxes in each class.
  std::array<size_t, kCount> ClassifyAll(const float* const (&extents)[3],
                                         std::span<uint32_t> classes) const;

 private:
  size_t ClassOf(float extent0, float extent1, float extent2) const;

  float long_from_[3];
  float step_;  // a lower bound of the longest side of large boxes
  bool all_ordinary_ = true;
};

}  // namespace sweepstake
