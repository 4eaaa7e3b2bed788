// "rotating-gravity", "random-gravity" and "free-fall": bodies accelerated by gravity between
// walls. The three differ only in which way gravity points (paper §6.1, table 2).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "engine_client/scene/counter_random.h"
#include "engine_client/scene/generated_scene.h"

namespace sweepstake {

// A wall hit with speed v returns kRestitution * v, slows each component along it by up to
// kFriction * v (Coulomb: resting objects stick where gravity leans less than that) and adds up to
// ±kScatter * v to it. Without the scatter of rough walls rotating gravity folds all objects into
// one line.
class FallingScene final : public GeneratedScene {
 public:
  static constexpr float kRestitution = 0.5F;
  static constexpr float kFriction = 0.5F;
  static constexpr float kScatter = 0.2F;

  // All REQUIRE: ValidateSceneOptions(options).ok().
  // -y, +x, +y, -x in turn, direction_interval_s each.
  static std::unique_ptr<FallingScene> RotatingGravity(const SceneOptions& options);
  // One direction per object, uniform on the sphere, for ever.
  static std::unique_ptr<FallingScene> RandomGravity(const SceneOptions& options);
  // -y for ever.
  static std::unique_ptr<FallingScene> FreeFall(const SceneOptions& options);

 private:
  using Direction = std::array<float, 3>;

  FallingScene(std::string_view name, const SceneOptions& options);

  void Move() override;
  void MoveBody(uint32_t object, const Direction& gravity);
  void Bounce(uint32_t object, int axis);
  void SpawnVelocities(const SceneOptions& options);
  const Direction& DirectionNow() const;

  float step_s_;
  float gravity_;
  float world_half_extent_;
  uint64_t steps_per_direction_;
  // One per object in random gravity, else the cycle that all objects share.
  std::vector<Direction> directions_;
  bool direction_per_object_ = false;
  std::array<std::vector<float>, 3> velocity_;
  CounterRandom scatter_;
};

}  // namespace sweepstake
