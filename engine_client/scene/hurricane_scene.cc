#include "engine_client/scene/hurricane_scene.h"

#include <algorithm>
#include <cmath>

#include "engine_client/scene/portable_math.h"

namespace sweepstake {
namespace {

constexpr float kTwoPi = 6.2831853F;

// REQUIRES: 0 <= angle < 4 pi.
float Wrap(float angle) { return angle >= kTwoPi ? angle - kTwoPi : angle; }

}  // namespace

HurricaneScene::HurricaneScene(const SceneOptions& options)
    : GeneratedScene("hurricane", CentredWorld(options.world_half_extent), options.object_count),
      step_s_(options.fixed_step_s),
      rise_(kRise * options.speed * options.fixed_step_s),
      world_half_extent_(options.world_half_extent),
      kicks_(options.motion_seed, RandomStream::kKick),
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
  const CounterRandom position(options.spawn_seed, RandomStream::kPosition);
  const CounterRandom phase(options.spawn_seed, RandomStream::kPhase);
  const float outermost = world_half_extent_ / (1 + kBreathing);
  const float core = kCore * world_half_extent_;
  for (uint32_t i = 0; i < options.object_count; ++i) {
    // u^(3/4), where u^(1/2) would fill the disc evenly: the density falls as r^(-2/3).
    const float unit = position.Unit(i, 0);
    radius_[i] = outermost * std::sqrt(unit * std::sqrt(unit));
    angle_[i] = kTwoPi * position.Unit(i, 2);
    phase_[i] = kTwoPi * phase.Unit(i, 0);
    const float orbit = std::max(radius_[i], core);
    const float speed = kSwirl * options.speed * std::sqrt(world_half_extent_ / orbit);
    turn_[i] = std::fmod(speed / orbit * step_s_, kTwoPi);
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
  const double breathing = 1 + kBreathing * portable::Sin(phase_[object]);
  const double radius = radius_[object] * breathing;
  const double angle = angle_[object];
  bodies().centre[0][object] = static_cast<float>(radius * portable::Cos(angle));
  bodies().centre[2][object] = static_cast<float>(radius * portable::Sin(angle));
}

}  // namespace sweepstake
