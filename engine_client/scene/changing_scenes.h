// Scenes in which the cheapest broad phase changes over time: regimes of a fixed number of frames
// follow one another, for ever from the first again. What a policy can win over the best fixed
// broad phase is decided here; scene/README.md lists what was measured.
//
// The world holds one object per unit of volume, half extents are log-uniform 0.145 to 0.725, as in
// the reference suite. The same name, count and seed give the same boxes bit for bit on every
// platform. Not thread-safe. Lengths in world units. All memory is taken at construction.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "sweepstake/scene.h"
#include "sweepstake/status.h"

namespace sweepstake {

// To tune policies on: rest-and-motion, waves, storms. To judge them by, from other generators:
// gather-and-scatter, day-and-night, arrivals.
std::span<const std::string_view> ChangingSceneNames();

// Frames of each regime of the scene. REQUIRES: one of ChangingSceneNames().
uint32_t RegimeFrames(std::string_view name);

// `object_count` is the most a frame holds. `regime_frames` takes the place of the scene's own
// number where it is not 0. kNotFound lists the names, kInvalidArgument is too large a count,
// kResourceExhausted one that memory does not hold.
Result<std::unique_ptr<Scene>> MakeChangingScene(std::string_view name, uint32_t object_count,
                                                 uint64_t seed, uint32_t regime_frames = 0);

}  // namespace sweepstake
