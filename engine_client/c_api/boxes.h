// Boxes and pairs on their way across the boundary, checked.
#pragma once

#include <cstring>
#include <span>

#include "engine_client/c_api/boundary.h"
#include "sweepstake/aabb.h"

namespace sweepstake::c_api {

// SWP_OK where `boxes` holds `count` boxes that a backend can take.
inline swp_result CheckBoxes(const swp_aabb* boxes, uint32_t count) noexcept {
  if (boxes == nullptr && count > 0) return NullArgument("boxes");
  if (count > 0x7fffffffU) return Fail(SWP_INVALID_ARGUMENT, "more than 2147483647 boxes");
  return SWP_OK;
}

inline std::span<const Aabb> ToBoxes(const swp_aabb* boxes, uint32_t count) {
  return {reinterpret_cast<const Aabb*>(boxes), count};
}

// Writes all pairs, or only their number where `capacity` does not hold them.
inline swp_result WritePairs(std::span<const OverlapPair> found, swp_pair* pairs, uint64_t capacity,
                             uint64_t* count) noexcept {
  *count = found.size();
  if (found.size() > capacity) {
    return Fail(SWP_RESOURCE_EXHAUSTED, "the buffer holds fewer pairs than there are");
  }
  if (!found.empty() && pairs != nullptr) std::memcpy(pairs, found.data(), found.size_bytes());
  return SWP_OK;
}

}  // namespace sweepstake::c_api
