#include "engine_client/scene/scenarios.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>
#include <utility>
#include <vector>

#include "engine_client/math/portable_math.h"
#include "engine_client/scene/generated_scene.h"
#include "engine_client/scene/random.h"

namespace sweepstake {
namespace {

constexpr double kTwoPi = 6.283185307179586;
constexpr float kTwoPiF = 6.2831853F;

// Each step moves each object on each axis by a uniform draw from ±speed * fixed_step_s. Walls
// reflect the object.
class BrownianScene final : public GeneratedScene {
 public:
  explicit BrownianScene(const SceneOptions& options)
      : GeneratedScene("brownian", CentredWorld(options.world_half_extent), options.object_count),
        kick_(options.speed * options.fixed_step_s),
        world_half_extent_(options.world_half_extent),
        random_(options.motion_seed, SceneDraw::kKick) {
    SpawnSizes(options, bodies());
    SpawnInsideWalls(options, bodies());
    ShowBodies();
  }

 private:
  void Move() override;

  float kick_;
  float world_half_extent_;
  CounterRandom random_;
};

void BrownianScene::Move() {
  const uint64_t first_draw = frame_index() * 3;
  for (uint32_t i = 0; i < object_count(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      float& x = bodies().centre[axis][i];
      const float reach = world_half_extent_ - bodies().half_extent[axis][i];
      x = Reflect(x + kick_ * random_.Symmetric(i, first_draw + axis), -reach, reach);
    }
  }
}

using Direction = std::array<float, 3>;

// The directions of gravity: a cycle that all objects share, or one direction per object.
struct Gravity {
  std::vector<Direction> directions;
  bool per_object = false;
};

// Objects fall between walls. What happens when an object hits a wall with speed v:
// - it bounces back with kRestitution * v
// - each component of its velocity along the wall is reduced by up to kFriction * v (Coulomb
//   friction: a resting object stays at rest if gravity is not inclined more than that)
// - each component changes by up to ±kScatter * v at random, like at a rough wall; otherwise
//   rotating gravity would move all objects onto one line
class FallingScene final : public GeneratedScene {
 public:
  FallingScene(std::string_view name, const SceneOptions& options, Gravity gravity);

 private:
  static constexpr float kRestitution = 0.5F;
  static constexpr float kFriction = 0.5F;
  static constexpr float kScatter = 0.2F;

  void Move() override;
  void MoveBody(uint32_t object, const Direction& gravity);
  void Bounce(uint32_t object, int axis);
  void SpawnVelocities(const SceneOptions& options);
  const Direction& SharedDirection() const;

  float step_s_;
  float acceleration_;
  float world_half_extent_;
  uint64_t steps_per_direction_;
  Gravity gravity_;
  std::array<std::vector<float>, 3> velocity_;
  CounterRandom scatter_;
};

uint64_t WholeSteps(float duration_s, float step_s) {
  const double steps = static_cast<double>(duration_s) / step_s;
  return std::max<uint64_t>(1, static_cast<uint64_t>(std::llround(steps)));
}

// Returns `velocity` moved towards 0 by `loss`, but not beyond 0.
float SlowedBy(float loss, float velocity) {
  if (velocity > 0) return std::max(0.0F, velocity - loss);
  return std::min(0.0F, velocity + loss);
}

// Returns a direction that is uniformly distributed on the unit sphere, given a number in [-1, 1)
// and one in [0, 1). The height is uniform (Archimedes).
Direction DirectionOnSphere(float symmetric, float unit) {
  const double height = symmetric;
  const double radius = std::sqrt(1 - height * height);
  const double angle = kTwoPi * unit;
  return {static_cast<float>(radius * math::Cos(angle)), static_cast<float>(height),
          static_cast<float>(radius * math::Sin(angle))};
}

FallingScene::FallingScene(std::string_view name, const SceneOptions& options, Gravity gravity)
    : GeneratedScene(name, CentredWorld(options.world_half_extent), options.object_count),
      step_s_(options.fixed_step_s),
      acceleration_(options.gravity),
      world_half_extent_(options.world_half_extent),
      steps_per_direction_(WholeSteps(options.direction_interval_s, options.fixed_step_s)),
      gravity_(std::move(gravity)),
      scatter_(options.motion_seed, SceneDraw::kKick) {
  SpawnSizes(options, bodies());
  SpawnInsideWalls(options, bodies());
  SpawnVelocities(options);
  ShowBodies();
}

void FallingScene::SpawnVelocities(const SceneOptions& options) {
  const CounterRandom random(options.motion_seed, SceneDraw::kVelocity);
  for (int axis = 0; axis < 3; ++axis) {
    velocity_[axis].resize(options.object_count);
    for (uint32_t i = 0; i < options.object_count; ++i) {
      velocity_[axis][i] = options.speed * random.Symmetric(i, axis);
    }
  }
}

const Direction& FallingScene::SharedDirection() const {
  const uint64_t turn = (frame_index() - 1) / steps_per_direction_;
  return gravity_.directions[turn % gravity_.directions.size()];
}

void FallingScene::Move() {
  for (uint32_t i = 0; i < object_count(); ++i) {
    MoveBody(i, gravity_.per_object ? gravity_.directions[i] : SharedDirection());
  }
}

void FallingScene::MoveBody(uint32_t object, const Direction& gravity) {
  for (int axis = 0; axis < 3; ++axis) {
    float& velocity = velocity_[axis][object];
    velocity += acceleration_ * gravity[axis] * step_s_;
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

// Objects orbit the vertical axis. H is world_half_extent, r is the mean radius of an orbit.
// - Outside the core of radius kCore * H the tangential speed is kOrbitSpeed * speed * sqrt(H / r).
//   The core turns like a rigid body.
// - The radius oscillates by a fraction of ±kBreathing at 1 rad/s, with a phase per object.
// - In each step the height changes by up to ±kRise * speed * fixed_step_s at random. Floor and
//   ceiling reflect it.
class HurricaneScene final : public GeneratedScene {
 public:
  explicit HurricaneScene(const SceneOptions& options);

 private:
  static constexpr float kOrbitSpeed = 4;
  static constexpr float kCore = 0.1F;
  static constexpr float kBreathing = 0.05F;
  static constexpr float kRise = 0.5F;

  void Move() override;
  void SpawnOrbits(const SceneOptions& options);
  void PlaceOnOrbit(uint32_t object);

  float step_s_;
  float rise_;
  float world_half_extent_;
  CounterRandom kicks_;
  std::vector<float> radius_;
  std::vector<float> angle_;  // the angle on the orbit, in [0, 2 pi)
  std::vector<float> phase_;  // the phase of the oscillation, in [0, 2 pi)
  std::vector<float> turn_;   // radians per step, below 2 pi
};

// Returns the angle in [0, 2 pi). REQUIRES: 0 <= angle < 4 pi.
float Wrap(float angle) { return angle >= kTwoPiF ? angle - kTwoPiF : angle; }

HurricaneScene::HurricaneScene(const SceneOptions& options)
    : GeneratedScene("hurricane", CentredWorld(options.world_half_extent), options.object_count),
      step_s_(options.fixed_step_s),
      rise_(kRise * options.speed * options.fixed_step_s),
      world_half_extent_(options.world_half_extent),
      kicks_(options.motion_seed, SceneDraw::kKick),
      radius_(options.object_count),
      angle_(options.object_count),
      phase_(options.object_count),
      turn_(options.object_count) {
  SpawnSizes(options, bodies());
  SpawnInsideWalls(options, bodies());
  SpawnOrbits(options);
  ShowBodies();
}

void HurricaneScene::SpawnOrbits(const SceneOptions& options) {
  const CounterRandom position(options.spawn_seed, SceneDraw::kPosition);
  const CounterRandom phase(options.spawn_seed, SceneDraw::kPhase);
  const float outermost = world_half_extent_ / (1 + kBreathing);
  const float core = kCore * world_half_extent_;
  for (uint32_t i = 0; i < options.object_count; ++i) {
    // u^(3/4) makes the density fall as r^(-2/3); u^(1/2) would fill the disc evenly.
    const float unit = position.Unit(i, 0);
    radius_[i] = outermost * std::sqrt(unit * std::sqrt(unit));
    angle_[i] = kTwoPiF * position.Unit(i, 2);
    phase_[i] = kTwoPiF * phase.Unit(i, 0);
    const float orbit = std::max(radius_[i], core);
    const float speed = kOrbitSpeed * options.speed * std::sqrt(world_half_extent_ / orbit);
    turn_[i] = std::fmod(speed / orbit * step_s_, kTwoPiF);
    PlaceOnOrbit(i);
  }
}

void HurricaneScene::Move() {
  for (uint32_t i = 0; i < object_count(); ++i) {
    angle_[i] = Wrap(angle_[i] + turn_[i]);
    phase_[i] = Wrap(phase_[i] + step_s_);
    float& height = bodies().centre[1][i];
    const float reach = world_half_extent_ - bodies().half_extent[1][i];
    height = Reflect(height + rise_ * kicks_.Symmetric(i, frame_index()), -reach, reach);
    PlaceOnOrbit(i);
  }
}

void HurricaneScene::PlaceOnOrbit(uint32_t object) {
  const double breathing = 1 + kBreathing * math::Sin(phase_[object]);
  const double radius = radius_[object] * breathing;
  const double angle = angle_[object];
  bodies().centre[0][object] = static_cast<float>(radius * math::Cos(angle));
  bodies().centre[2][object] = static_cast<float>(radius * math::Sin(angle));
}

}  // namespace

std::unique_ptr<Scene> MakeBrownian(const SceneOptions& options) {
  return std::make_unique<BrownianScene>(options);
}

std::unique_ptr<Scene> MakeRotatingGravity(const SceneOptions& options) {
  Gravity gravity{{{0, -1, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}}};
  return std::make_unique<FallingScene>("rotating-gravity", options, std::move(gravity));
}

std::unique_ptr<Scene> MakeRandomGravity(const SceneOptions& options) {
  const CounterRandom random(options.motion_seed, SceneDraw::kDirection);
  Gravity gravity{{}, true};
  gravity.directions.reserve(options.object_count);
  for (uint32_t i = 0; i < options.object_count; ++i) {
    gravity.directions.push_back(DirectionOnSphere(random.Symmetric(i, 0), random.Unit(i, 1)));
  }
  return std::make_unique<FallingScene>("random-gravity", options, std::move(gravity));
}

std::unique_ptr<Scene> MakeFreeFall(const SceneOptions& options) {
  return std::make_unique<FallingScene>("free-fall", options, Gravity{{{0, -1, 0}}});
}

std::unique_ptr<Scene> MakeHurricane(const SceneOptions& options) {
  return std::make_unique<HurricaneScene>(options);
}

}  // namespace sweepstake
