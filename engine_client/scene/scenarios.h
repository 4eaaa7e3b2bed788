// The five scenarios of the paper (§6.1, table 2). The README.md of this folder describes them and
// how each uses its options.
//
// All functions REQUIRE options within the ranges in sweepstake/scene.h.
#pragma once

#include <memory>

#include "sweepstake/scene.h"

namespace sweepstake {

// Each object moves by a random amount in each step. Objects stay spread over the world.
std::unique_ptr<Scene> MakeBrownian(const SceneOptions& options);

// Objects fall between walls. The direction of gravity differs:
// - MakeRotatingGravity: -y, +x, +y, -x in turn
// - MakeRandomGravity: one random direction per object, uniform on the sphere
// - MakeFreeFall: always -y
std::unique_ptr<Scene> MakeRotatingGravity(const SceneOptions& options);
std::unique_ptr<Scene> MakeRandomGravity(const SceneOptions& options);
std::unique_ptr<Scene> MakeFreeFall(const SceneOptions& options);

// Objects orbit the vertical axis at high speed. The scene is dense near the axis, and neighbours
// move alike.
std::unique_ptr<Scene> MakeHurricane(const SceneOptions& options);

}  // namespace sweepstake
