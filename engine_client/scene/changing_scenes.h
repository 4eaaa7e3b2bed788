// Scenes in which the cheapest broad phase changes over time. Regimes of a fixed number of frames
// repeat in a cycle. Such scenes show how much a policy can gain compared with the best fixed broad
// phase; scene/README.md lists the measured gains.
//
// rest-and-motion, waves and storms are for tuning policies. gather-and-scatter, day-and-night and
// arrivals have other kinds of motion and are for judging policies.
//
// The world has one object per unit of volume. Half extents are log-uniform from 0.145 to 0.725, as
// in the reference suite. The same name, count and seed give the same boxes, bit for bit, on every
// platform. Not thread-safe. Lengths are in world units. All memory is allocated at construction.
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>

#include "sweepstake/scene.h"

namespace sweepstake {

// `object_count` is the maximum of a frame. A `regime_frames` other than 0 replaces the scene's own
// number of frames per regime. REQUIRES: `name` is in SceneNames(SceneGroup::kChanging).
std::unique_ptr<Scene> MakeChangingScene(std::string_view name, uint32_t object_count,
                                         uint64_t seed, uint32_t regime_frames = 0);

}  // namespace sweepstake
