// Axis-aligned bounding boxes, and the definition of overlap that every backend must reproduce.
#pragma once

#include <cmath>
#include <compare>
#include <cstdint>
#include <limits>

namespace sweepstake {

static_assert(sizeof(void*) == 8, "Sweepstake needs a 64-bit target");

// Six floats in world units, 24 bytes without padding. The engine's buffer and the C ABI use the
// same layout.
struct Aabb {
  float min[3];
  float max[3];

  friend bool operator==(const Aabb&, const Aabb&) = default;
};
static_assert(sizeof(Aabb) == 24);

// Two objects, by index in the engine's buffer; a < b.
struct OverlapPair {
  uint32_t a;
  uint32_t b;

  // clang-tidy reports a comparison with 0 that the compiler generates.
  // NOLINTNEXTLINE(modernize-use-nullptr)
  friend auto operator<=>(const OverlapPair&, const OverlapPair&) = default;
};
static_assert(sizeof(OverlapPair) == 8);

// A box is valid if all six coordinates are finite and min <= max on each axis. Its size may be
// zero. An invalid box (NaN, infinite or inverted) overlaps nothing, not even itself.
//
// Give an object without bounds, such as a plane or the sky, huge finite faces instead of infinite
// ones: a box of ±1e30 on an axis overlaps everything on it, with every backend. An empty box, with
// min > max on all axes, marks an unused place. FrameSample counts the other invalid boxes, which
// are probably mistakes.
inline bool IsValid(const Aabb& box) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!std::isfinite(box.min[axis]) || !std::isfinite(box.max[axis])) return false;
    if (box.min[axis] > box.max[axis]) return false;
  }
  return true;
}

// Returns whether the boxes overlap. Boxes are closed, so boxes whose faces touch overlap.
// Comparisons are exact, without tolerance.
inline bool Overlap(const Aabb& a, const Aabb& b) {
  if (!IsValid(a) || !IsValid(b)) return false;
  for (int axis = 0; axis < 3; ++axis) {
    if (a.min[axis] > b.max[axis] || b.min[axis] > a.max[axis]) return false;
  }
  return true;
}

// Returns the smallest box of floats that contains the given box of doubles: min is rounded down,
// max is rounded up. A coordinate beyond the range of float becomes infinite, which makes the box
// invalid.
//
// If min <= max is violated on an axis, the result is invalid too, even if both round to the same
// float.
inline Aabb RoundOutward(const double min[3], const double max[3]) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  Aabb box;
  for (int axis = 0; axis < 3; ++axis) {
    box.min[axis] = static_cast<float>(min[axis]);
    box.max[axis] = static_cast<float>(max[axis]);
    if (box.min[axis] > min[axis]) box.min[axis] = std::nextafter(box.min[axis], -kInfinity);
    if (box.max[axis] < max[axis]) box.max[axis] = std::nextafter(box.max[axis], kInfinity);
    if (!(min[axis] <= max[axis])) box.min[axis] = kInfinity;
  }
  return box;
}

}  // namespace sweepstake
