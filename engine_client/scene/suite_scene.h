// "suite-b", "suite-g", "suite-h": the reference suite that all published figures use. Density 1
// (the world's side is the cube root of the object count), half extents log-uniform 0.145 to 0.725,
// positions in one corner-anchored cube.
//
// Everything but the object count is fixed, the seed included, so that a figure names its scene by
// letter and count.
#pragma once

#include <cstdint>
#include <memory>

#include "sweepstake/scene.h"

namespace sweepstake {

std::unique_ptr<Scene> MakeSuiteBrownian(uint32_t object_count);
std::unique_ptr<Scene> MakeSuiteGravity(uint32_t object_count);
std::unique_ptr<Scene> MakeSuiteHurricane(uint32_t object_count);

}  // namespace sweepstake
