// BoxRecord stores a box for exact overlap tests: two vectors of four floats, half a cache line.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "sweepstake/aabb.h"

namespace sweepstake {

// The fourth element is 0, so that it passes every comparison. An invalid box (aabb.h) becomes
// kInvalidRecord, which overlaps nothing.
struct alignas(32) BoxRecord {
  float min[4];
  float max[4];

  friend bool operator==(const BoxRecord&, const BoxRecord&) = default;
};

inline constexpr float kInfinity = std::numeric_limits<float>::infinity();
inline constexpr BoxRecord kInvalidRecord = {{kInfinity, kInfinity, kInfinity, 0},
                                             {-kInfinity, -kInfinity, -kInfinity, 0}};

// An invalid box that overlaps nothing and lies inside every box.
inline constexpr Aabb kInvalidAabb = {{kInfinity, kInfinity, kInfinity},
                                      {-kInfinity, -kInfinity, -kInfinity}};

// As IsValid, in half the time for most valid boxes. REQUIRES: the library's floating-point
// environment (float_environment.h).
inline bool IsValidFast(const Aabb& box) {
  uint32_t largest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    // Negative values, infinities and NaN have larger bits than any finite value from 0 on.
    largest = std::max(largest, std::bit_cast<uint32_t>(box.max[axis] - box.min[axis]));
  }
  // The difference of two finite coordinates may be infinite.
  return largest < uint32_t{aabb_detail::kInfinity} || IsValid(box);
}

inline BoxRecord RecordOf(const Aabb& box) {
  if (!IsValidFast(box)) return kInvalidRecord;
  return {{box.min[0], box.min[1], box.min[2], 0}, {box.max[0], box.max[1], box.max[2], 0}};
}

// Stores boxes[i] in records[i].
void StoreRecords(std::span<const Aabb> boxes, BoxRecord* records);

// FindMoved lists in `moved` the index of each box that differs from its record, with the bit
// kBecameInvalid set if the box is invalid. Returns the number of these boxes. REQUIRES: `moved`
// has room for boxes.size() entries.
inline constexpr uint32_t kBecameInvalid = 0x80000000;
size_t FindMoved(std::span<const Aabb> boxes, const BoxRecord* records, uint32_t* moved);

inline bool Overlap(const BoxRecord& a, const BoxRecord& b) {
  bool overlap = true;
  for (int axis = 0; axis < 3; ++axis)
    overlap = overlap && a.min[axis] <= b.max[axis] && b.min[axis] <= a.max[axis];
  return overlap;
}

}  // namespace sweepstake
