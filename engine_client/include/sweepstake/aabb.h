// Axis-aligned bounding boxes, and the definition of overlap that every backend must reproduce.
#pragma once

#include <bit>
#include <compare>
#include <cstdint>

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

namespace aabb_detail {

inline constexpr int32_t kInfinity = 0x7F80'0000;

// Returns an integer in the order of the floats. Both zeros give 0, infinities ±kInfinity, and NaN
// a value beyond them. Without a branch, because signs are hard to predict.
constexpr int32_t OrderedBits(float value) {
  const auto bits = std::bit_cast<int32_t>(value);
  const int32_t sign = bits >> 31;  // -1 for a negative value, otherwise 0
  return ((bits & 0x7FFF'FFFF) ^ sign) - sign;
}

// Returns the float whose bits are the float nearest to |value| that is not above it, or not below
// it if `up`. NaN gives NaN.
constexpr uint32_t RoundMagnitude(uint64_t bits, bool up) {
  constexpr uint64_t kInfinityOfDouble = 0x7FF0'0000'0000'0000;
  constexpr int kDroppedBits = 52 - 23;
  constexpr uint64_t kSmallestNormal = uint64_t{1023 - 126} << 52;
  if (bits > kInfinityOfDouble) return 0x7FC0'0000;
  if (bits == kInfinityOfDouble) return kInfinity;
  int dropped = kDroppedBits;
  uint64_t kept = bits;
  if (bits >= kSmallestNormal) {
    kept -= uint64_t{1023 - 127} << 52;  // the exponent of a float has another bias
  } else {                               // the result is subnormal or 0
    const auto exponent = static_cast<int>(bits >> 52);
    dropped += 1023 - 126 - exponent;
    kept = exponent == 0 ? 0 : (bits & 0xF'FFFF'FFFF'FFFF) | uint64_t{1} << 52;
    if (dropped > 63) dropped = 63;
  }
  const uint64_t truncated = kept >> dropped;
  const bool is_exact = bits == 0 || (kept != 0 && truncated << dropped == kept);
  if (truncated >= kInfinity) return up ? kInfinity : kInfinity - 1;
  return static_cast<uint32_t>(truncated) + (up && !is_exact ? 1 : 0);
}

// Returns the float nearest to `value` that is not above it, or not below it if `up`.
constexpr float RoundToward(double value, bool up) {
  const auto bits = std::bit_cast<uint64_t>(value);
  const bool is_negative = (bits >> 63) != 0;
  const uint32_t magnitude = RoundMagnitude(bits & ~(uint64_t{1} << 63), up != is_negative);
  return std::bit_cast<float>(magnitude | (is_negative ? uint32_t{1} << 31 : 0));
}

// As OrderedBits; NaN gives a value beyond the infinities.
constexpr int64_t OrderedBits(double value) {
  const auto bits = std::bit_cast<int64_t>(value);
  const int64_t sign = bits >> 63;
  return ((bits & 0x7FFF'FFFF'FFFF'FFFF) ^ sign) - sign;
}

}  // namespace aabb_detail

// A box is valid if all six coordinates are finite and min <= max on each axis. Its size may be
// zero. An invalid box (NaN, infinite or inverted) overlaps nothing, not even itself.
//
// Give an object without bounds, such as a plane or the sky, huge finite faces instead of infinite
// ones: a box of ±1e30 on an axis overlaps everything on it, with every backend. An empty box, with
// min > max on all axes, marks an unused place. FrameSample counts the other invalid boxes, which
// are probably mistakes.
//
// This and the other functions below are compiled with the flags of the game, which may be
// -ffast-math, and run in its floating-point environment. They therefore compare bits.
inline bool IsValid(const Aabb& box) {
  for (int axis = 0; axis < 3; ++axis) {
    const int32_t min = aabb_detail::OrderedBits(box.min[axis]);
    const int32_t max = aabb_detail::OrderedBits(box.max[axis]);
    if (!(-aabb_detail::kInfinity < min && min <= max && max < aabb_detail::kInfinity)) {
      return false;
    }
  }
  return true;
}

// Returns whether the boxes overlap. Boxes are closed, so boxes whose faces touch overlap.
// Comparisons are exact, without tolerance.
inline bool Overlap(const Aabb& a, const Aabb& b) {
  if (!IsValid(a) || !IsValid(b)) return false;
  for (int axis = 0; axis < 3; ++axis) {
    if (aabb_detail::OrderedBits(a.min[axis]) > aabb_detail::OrderedBits(b.max[axis]) ||
        aabb_detail::OrderedBits(b.min[axis]) > aabb_detail::OrderedBits(a.max[axis])) {
      return false;
    }
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
  Aabb box;
  for (int axis = 0; axis < 3; ++axis) {
    const bool is_ordered =
        aabb_detail::OrderedBits(min[axis]) <= aabb_detail::OrderedBits(max[axis]);
    box.min[axis] = is_ordered ? aabb_detail::RoundToward(min[axis], false)
                               : std::bit_cast<float>(aabb_detail::kInfinity);
    box.max[axis] = aabb_detail::RoundToward(max[axis], true);
  }
  return box;
}

}  // namespace sweepstake
