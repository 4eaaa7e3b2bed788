// A box in one half of a cache line, as two vectors of four floats: what an exact test of two boxes
// loads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "sweepstake/aabb.h"

namespace sweepstake {

// The fourth element is 0, so that it always passes the comparison of the other three. A box that
// does not take part (aabb.h) is kAbsentBox, which overlaps nothing.
struct alignas(32) BoxRecord {
  float min[4];
  float max[4];

  friend bool operator==(const BoxRecord&, const BoxRecord&) = default;
};

inline constexpr float kFarthest = std::numeric_limits<float>::infinity();
inline constexpr BoxRecord kAbsentBox = {{kFarthest, kFarthest, kFarthest, 0},
                                         {-kFarthest, -kFarthest, -kFarthest, 0}};

// An invalid box that overlaps nothing and lies inside every box.
inline constexpr Aabb kInvalidAabb = {{kFarthest, kFarthest, kFarthest},
                                      {-kFarthest, -kFarthest, -kFarthest}};

inline BoxRecord RecordOf(const Aabb& box) {
  if (!TakesPart(box)) return kAbsentBox;
  return {{box.min[0], box.min[1], box.min[2], 0}, {box.max[0], box.max[1], box.max[2], 0}};
}

// records[i] takes boxes[i]: 1 ns each.
void TakeRecords(std::span<const Aabb> boxes, BoxRecord* records);

// Of the boxes that are not the same as the record with their index: that index in `moved`, with
// kMovedAway where the box does not take part. Returns how many; `moved` has room for all.
inline constexpr uint32_t kMovedAway = 0x80000000;
size_t FindMoved(std::span<const Aabb> boxes, const BoxRecord* records, uint32_t* moved);

inline bool Overlap(const BoxRecord& a, const BoxRecord& b) {
  bool overlap = true;
  for (int axis = 0; axis < 3; ++axis)
    overlap = overlap && a.min[axis] <= b.max[axis] && b.min[axis] <= a.max[axis];
  return overlap;
}

}  // namespace sweepstake
