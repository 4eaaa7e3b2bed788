// The kinds of box_scenes.h as scenes, but for brownian, which is the name of a scenario; besides
// them `empty`, `one` and `two` (so many objects), `count-changing` (a mixture of which every frame
// shows another number of objects, none included) and `spawning` (a brownian crowd that gains or
// loses a 64th of its objects per frame, between half of them and all).
//
// The same name, count and seed give the same boxes bit for bit. Not thread-safe.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "sweepstake/scene.h"
#include "sweepstake/status.h"

namespace sweepstake {

// `mixture` is the last one.
std::span<const std::string_view> DegenerateSceneNames();

// `object_count` is the most a frame holds; empty, one and two ignore it.
// kNotFound lists the names, kInvalidArgument is too large a count,
// kResourceExhausted one that memory does not hold.
Result<std::unique_ptr<Scene>> MakeDegenerateScene(std::string_view name, uint32_t object_count,
                                                   uint64_t seed);

}  // namespace sweepstake
