// The distance at which a ray enters a box: the definition that the vector search (tree_queries.cc)
// must reproduce.
//
// The slab test (Kay & Kajiya, Ray Tracing Complex Scenes, 1986), with divisions instead of a
// reciprocal, and minima and maxima in a fixed order. Every step rounds monotonically: a ray that
// hits a box also hits the bounds of every node around it, and all machines agree to the last bit.
// With a finite ray and a valid box no step gives NaN. Stateless.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "sweepstake/aabb.h"
#include "sweepstake/proxy_set.h"

namespace sweepstake {

inline bool IsFinite(const Ray& ray) {
  bool finite = std::isfinite(ray.max_distance);
  for (int axis = 0; axis < 3; ++axis) {
    finite = finite && std::isfinite(ray.origin[axis]) && std::isfinite(ray.direction[axis]);
  }
  return finite;
}

// Returns nothing if the ray misses the box. REQUIRES: IsFinite(ray).
inline std::optional<float> EnterDistance(const Ray& ray, const Aabb& box) {
  if (!IsValid(box)) return std::nullopt;
  float enter = 0;
  float leave = ray.max_distance;
  for (int axis = 0; axis < 3; ++axis) {
    const float direction = ray.direction[axis];
    const float to_min = box.min[axis] - ray.origin[axis];
    const float to_max = box.max[axis] - ray.origin[axis];
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

}  // namespace sweepstake
