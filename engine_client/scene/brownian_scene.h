// "brownian": independent random kicks each step; a spatially diffuse scene (paper §6.1, table 2).
#pragma once

#include "engine_client/scene/counter_random.h"
#include "engine_client/scene/generated_scene.h"

namespace sweepstake {

// Each step moves each object on each axis by a uniform draw from ±speed * fixed_step_s; walls
// reflect it.
class BrownianScene final : public GeneratedScene {
 public:
  // REQUIRES: ValidateSceneOptions(options).ok().
  explicit BrownianScene(const SceneOptions& options);

 private:
  void Move() override;

  float kick_;
  float world_half_extent_;
  CounterRandom random_;
};

}  // namespace sweepstake
