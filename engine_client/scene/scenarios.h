// The five scenarios of the paper (§6.1, table 2); what each does with its options: README.md of
// this folder.
//
// All REQUIRE options within the ranges that sweepstake/scene.h gives.
#pragma once

#include <memory>

#include "sweepstake/scene.h"

namespace sweepstake {

// Independent random kicks in each step; a spatially diffuse scene.
std::unique_ptr<Scene> MakeBrownian(const SceneOptions& options);

// Bodies between walls. Gravity points to -y, +x, +y, -x in turn; in one random direction per
// object, uniform on the sphere; always to -y.
std::unique_ptr<Scene> MakeRotatingGravity(const SceneOptions& options);
std::unique_ptr<Scene> MakeRandomGravity(const SceneOptions& options);
std::unique_ptr<Scene> MakeFreeFall(const SceneOptions& options);

// Objects orbit the vertical axis at high speed, faster towards it; dense and coherent.
std::unique_ptr<Scene> MakeHurricane(const SceneOptions& options);

}  // namespace sweepstake
