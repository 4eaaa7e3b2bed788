// Definitions that the vector search (tree_queries.cc) must reproduce: the distance at which a ray
// or a moving box enters a box, and the distance of a box from a point.
//
// Rays use the slab test (Kay & Kajiya, Ray Tracing Complex Scenes, 1986), with divisions instead
// of a reciprocal, and minima and maxima in a fixed order. Every step rounds monotonically. A ray
// that hits a box therefore also hits the bounds of every node around it, and all machines agree to
// the last bit. With finite values and a valid box no step gives NaN. Stateless.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "sweepstake/aabb.h"
#include "sweepstake/proxy_set.h"

namespace sweepstake {

// A box [min, max] that moves by t · direction, with t from 0 to max_distance. For a ray, both min
// and max are its origin.
struct Slabs {
  float min[3];
  float max[3];
  float direction[3];
  float max_distance;
};

inline Slabs SlabsOf(const Ray& ray) {
  Slabs slabs{};
  std::copy_n(ray.origin, 3, slabs.min);
  std::copy_n(ray.origin, 3, slabs.max);
  std::copy_n(ray.direction, 3, slabs.direction);
  slabs.max_distance = ray.max_distance;
  return slabs;
}

inline Slabs SlabsOf(const BoxSweep& sweep) {
  Slabs slabs{};
  std::copy_n(sweep.box.min, 3, slabs.min);
  std::copy_n(sweep.box.max, 3, slabs.max);
  std::copy_n(sweep.translation, 3, slabs.direction);
  slabs.max_distance = 1;
  return slabs;
}

inline bool IsFinite(const Slabs& slabs) {
  bool finite = std::isfinite(slabs.max_distance);
  for (int axis = 0; axis < 3; ++axis) {
    finite = finite && std::isfinite(slabs.min[axis]) && std::isfinite(slabs.max[axis]) &&
             std::isfinite(slabs.direction[axis]);
  }
  return finite;
}

// Returns the distance at which the slabs enter the box, or nothing if they miss it. REQUIRES:
// IsFinite(slabs).
inline std::optional<float> EnterDistance(const Slabs& slabs, const Aabb& box) {
  if (!IsValid(box)) return std::nullopt;
  float enter = 0;
  float leave = slabs.max_distance;
  for (int axis = 0; axis < 3; ++axis) {
    const float direction = slabs.direction[axis];
    const float to_min = box.min[axis] - slabs.max[axis];
    const float to_max = box.max[axis] - slabs.min[axis];
    if (direction == 0) {
      if (to_min > 0 || to_max < 0) return std::nullopt;
      continue;
    }
    enter = std::max(enter, (direction > 0 ? to_min : to_max) / direction);
    leave = std::min(leave, (direction > 0 ? to_max : to_min) / direction);
  }
  if (enter > leave) return std::nullopt;
  return enter + 0.0F;  // −0 + 0 = +0
}

// Returns the square of the distance from the point to the box; 0 if the point is inside. Every
// step rounds monotonically. REQUIRES: the point is finite, the box is valid.
inline float SquaredDistance(const float point[3], const Aabb& box) {
  float sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const float outside =
        std::max(0.0F, std::max(box.min[axis] - point[axis], point[axis] - box.max[axis]));
    sum += outside * outside;
  }
  return sum;
}

}  // namespace sweepstake
