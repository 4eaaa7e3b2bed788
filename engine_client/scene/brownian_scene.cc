#include "engine_client/scene/brownian_scene.h"

namespace sweepstake {

BrownianScene::BrownianScene(const SceneOptions& options)
    : GeneratedScene("brownian", CentredWorld(options.world_half_extent), options.object_count),
      kick_(options.speed * options.fixed_step_s),
      world_half_extent_(options.world_half_extent),
      random_(options.motion_seed, RandomStream::kKick) {
  SpawnSizes(options, bodies());
  SpawnInsideWalls(options, bodies());
  ShowBodies();
}

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

}  // namespace sweepstake
