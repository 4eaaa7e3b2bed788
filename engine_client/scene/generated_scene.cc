#include "engine_client/scene/generated_scene.h"

#include <algorithm>

#include "engine_client/math/portable_math.h"
#include "engine_client/scene/random.h"

namespace sweepstake {

Bodies::Bodies(uint32_t object_count) {
  for (std::vector<float>& axis : centre) axis.resize(object_count);
  for (std::vector<float>& axis : half_extent) axis.resize(object_count);
}

GeneratedScene::GeneratedScene(std::string_view name, const Aabb& world, uint32_t object_count)
    : name_(name), world_(world), bodies_(object_count), aabbs_(object_count) {}

void GeneratedScene::DoStep() {
  ++frame_index_;
  Move();
  ShowBodies();
}

void GeneratedScene::ShowBodies() {
  for (size_t i = 0; i < aabbs_.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const float centre = bodies_.centre[axis][i];
      const float half_extent = bodies_.half_extent[axis][i];
      aabbs_[i].min[axis] = centre - half_extent;
      aabbs_[i].max[axis] = centre + half_extent;
    }
  }
}

Aabb CentredWorld(float half_extent) {
  return {{-half_extent, -half_extent, -half_extent}, {half_extent, half_extent, half_extent}};
}

void SpawnSizes(const SceneOptions& options, Bodies& bodies) {
  const CounterRandom random(options.spawn_seed, SceneDraw::kSize);
  const double min = options.half_extent_min;
  const double log_ratio = math::Log(options.half_extent_max / min);
  for (uint32_t i = 0; i < options.object_count; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const double drawn = min * math::Exp(log_ratio * random.Unit(i, axis));
      bodies.half_extent[axis][i] =
          std::clamp(static_cast<float>(drawn), options.half_extent_min, options.half_extent_max);
    }
  }
}

void SpawnInsideWalls(const SceneOptions& options, Bodies& bodies) {
  const CounterRandom random(options.spawn_seed, SceneDraw::kPosition);
  for (uint32_t i = 0; i < options.object_count; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const float reach = options.world_half_extent - bodies.half_extent[axis][i];
      bodies.centre[axis][i] = reach * random.Symmetric(i, axis);
    }
  }
}

float Reflect(float x, float low, float high) {
  if (x < low) x = 2 * low - x;
  if (x > high) x = 2 * high - x;
  return std::clamp(x, low, high);
}

}  // namespace sweepstake
