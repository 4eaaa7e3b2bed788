// The five scenarios of the paper (§6.1, table 2). README.md of this folder states how each uses
// its options.
//
// All functions REQUIRE options within the ranges in sweepstake/scene.h.
#pragma once

#include <memory>

#include "sweepstake/scene.h"

namespace sweepstake {

// Independent random kicks in each step: a spatially diffuse scene.
std::unique_ptr<Scene> MakeBrownian(const SceneOptions& options);

// Bodies between walls. Gravity points to -y, +x, +y, -x in turn (MakeRotatingGravity), in one
// random direction per object, uniform on the sphere (MakeRandomGravity), or always to -y
// (MakeFreeFall).
std::unique_ptr<Scene> MakeRotatingGravity(const SceneOptions& options);
std::unique_ptr<Scene> MakeRandomGravity(const SceneOptions& options);
std::unique_ptr<Scene> MakeFreeFall(const SceneOptions& options);

// Objects orbit the vertical axis at high speed, faster near the axis: a dense and coherent scene.
std::unique_ptr<Scene> MakeHurricane(const SceneOptions& options);

}  // namespace sweepstake
