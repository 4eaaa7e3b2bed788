// "hurricane": objects orbit the vertical axis at high speed, faster towards it; dense and coherent
// (paper §6.1).
#pragma once

#include <vector>

#include "engine_client/scene/counter_random.h"
#include "engine_client/scene/generated_scene.h"

namespace sweepstake {

// With H = world_half_extent and r the mean radius of an orbit: tangential speed kSwirl * speed *
// sqrt(H / r) outside the core of radius kCore * H, inside it the core turns as one body. The
// radius breathes by ±kBreathing of itself at 1 rad/s with a phase per object; the height takes
// kicks of ±kRise * speed * fixed_step_s and is reflected.
class HurricaneScene final : public GeneratedScene {
 public:
  static constexpr float kSwirl = 4;
  static constexpr float kCore = 0.1F;
  static constexpr float kBreathing = 0.05F;
  static constexpr float kRise = 0.5F;

  // REQUIRES: ValidateSceneOptions(options).ok().
  explicit HurricaneScene(const SceneOptions& options);

 private:
  void Move() override;
  void SpawnOrbits(const SceneOptions& options);
  void PlaceOnOrbit(uint32_t object);

  float step_s_;
  float rise_;
  float world_half_extent_;
  CounterRandom kicks_;
  std::vector<float> radius_;
  std::vector<float> angle_;  // in [0, 2 pi)
  std::vector<float> phase_;  // of the breathing, in [0, 2 pi)
  std::vector<float> turn_;   // radians per step, below 2 pi
};

}  // namespace sweepstake
