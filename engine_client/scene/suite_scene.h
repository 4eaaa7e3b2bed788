// "suite-b", "suite-g", "suite-h": the reference suite that all published figures use. Density 1
// (the world's side is the cube root of the object count), half extents log-uniform 0.145 to 0.725,
// positions in the cube [0, side]³.
//
// Everything except the object count is fixed, including the seed. A letter and a count therefore
// identify a scene.
#pragma once

#include <cstdint>
#include <memory>

#include "sweepstake/scene.h"

namespace sweepstake {

std::unique_ptr<Scene> MakeSuiteBrownian(uint32_t object_count);
std::unique_ptr<Scene> MakeSuiteGravity(uint32_t object_count);
std::unique_ptr<Scene> MakeSuiteHurricane(uint32_t object_count);

}  // namespace sweepstake
