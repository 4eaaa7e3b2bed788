#include "engine_client/scene/falling_scene.h"

#include <algorithm>
#include <cmath>

#include "engine_client/scene/portable_math.h"

namespace sweepstake {
namespace {

constexpr double kTwoPi = 6.283185307179586;

uint64_t WholeSteps(float duration_s, float step_s) {
  const double steps = static_cast<double>(duration_s) / step_s;
  return std::max<uint64_t>(1, static_cast<uint64_t>(std::llround(steps)));
}

// `velocity` moved towards 0 by `loss`, never past it.
float SlowedBy(float loss, float velocity) {
  if (velocity > 0) return std::max(0.0F, velocity - loss);
  return std::min(0.0F, velocity + loss);
}

// Uniform on the unit sphere: the height is uniform (Archimedes).
std::array<float, 3> DirectionOnSphere(float symmetric, float unit) {
  const double height = symmetric;
  const double radius = std::sqrt(1 - height * height);
  const double angle = kTwoPi * unit;
  return {static_cast<float>(radius * portable::Cos(angle)), static_cast<float>(height),
          static_cast<float>(radius * portable::Sin(angle))};
}

}  // namespace

FallingScene::FallingScene(std::string_view name, const SceneOptions& options)
    : GeneratedScene(name, CentredWorld(options.world_half_extent), options.object_count),
      step_s_(options.fixed_step_s),
      gravity_(options.gravity),
      world_half_extent_(options.world_half_extent),
      steps_per_direction_(WholeSteps(options.direction_interval_s, options.fixed_step_s)),
      scatter_(options.motion_seed, RandomStream::kKick) {
  SpawnSizes(options, bodies());
  SpawnInsideWalls(options, bodies());
  SpawnVelocities(options);
  ShowBodies();
}

std::unique_ptr<FallingScene> FallingScene::RotatingGravity(const SceneOptions& options) {
  std::unique_ptr<FallingScene> scene(new FallingScene("rotating-gravity", options));
  scene->directions_ = {{0, -1, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}};
  return scene;
}

std::unique_ptr<FallingScene> FallingScene::RandomGravity(const SceneOptions& options) {
  std::unique_ptr<FallingScene> scene(new FallingScene("random-gravity", options));
  const CounterRandom random(options.motion_seed, RandomStream::kDirection);
  scene->direction_per_object_ = true;
  scene->directions_.reserve(options.object_count);
  for (uint32_t i = 0; i < options.object_count; ++i) {
    scene->directions_.push_back(DirectionOnSphere(random.Symmetric(i, 0), random.Unit(i, 1)));
  }
  return scene;
}

std::unique_ptr<FallingScene> FallingScene::FreeFall(const SceneOptions& options) {
  std::unique_ptr<FallingScene> scene(new FallingScene("free-fall", options));
  scene->directions_ = {{0, -1, 0}};
  return scene;
}

void FallingScene::SpawnVelocities(const SceneOptions& options) {
  const CounterRandom random(options.motion_seed, RandomStream::kVelocity);
  for (int axis = 0; axis < 3; ++axis) {
    velocity_[axis].resize(options.object_count);
    for (uint32_t i = 0; i < options.object_count; ++i) {
      velocity_[axis][i] = options.speed * random.Symmetric(i, axis);
    }
  }
}

const FallingScene::Direction& FallingScene::DirectionNow() const {
  return directions_[((frame_index() - 1) / steps_per_direction_) % directions_.size()];
}

void FallingScene::Move() {
  for (uint32_t i = 0; i < object_count(); ++i) {
    MoveBody(i, direction_per_object_ ? directions_[i] : DirectionNow());
  }
}

void FallingScene::MoveBody(uint32_t object, const Direction& gravity) {
  for (int axis = 0; axis < 3; ++axis) {
    float& velocity = velocity_[axis][object];
    velocity += gravity_ * gravity[axis] * step_s_;
    bodies().centre[axis][object] += velocity * step_s_;
    Bounce(object, axis);
  }
}

void FallingScene::Bounce(uint32_t object, int axis) {
  const float reach = world_half_extent_ - bodies().half_extent[axis][object];
  float& x = bodies().centre[axis][object];
  float& velocity = velocity_[axis][object];
  const bool hit = (x < -reach && velocity < 0) || (x > reach && velocity > 0);
  x = std::clamp(x, -reach, reach);
  if (!hit) return;
  const float impact = std::fabs(velocity);
  velocity *= -kRestitution;
  for (int turn = 1; turn < 3; ++turn) {
    const int along = (axis + turn) % 3;
    const uint64_t draw = frame_index() * 9 + static_cast<uint64_t>(axis * 3 + along);
    float& sliding = velocity_[along][object];
    sliding = SlowedBy(kFriction * impact, sliding) +
              kScatter * impact * scatter_.Symmetric(object, draw);
  }
}

}  // namespace sweepstake
