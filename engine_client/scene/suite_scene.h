// "suite-b", "suite-g", "suite-h": the reference suite, on which all published figures are
// measured. The density is 1: the world is the cube [0, side]³, where side is the cube root of the
// object count. Half extents are log-uniform from 0.145 to 0.725.
//
// Everything except the object count is fixed, including the seed. So a letter and a count identify
// a scene.
#pragma once

#include <cstdint>
#include <memory>

#include "sweepstake/scene.h"

namespace sweepstake {

std::unique_ptr<Scene> MakeSuiteBrownian(uint32_t object_count);
std::unique_ptr<Scene> MakeSuiteGravity(uint32_t object_count);
std::unique_ptr<Scene> MakeSuiteHurricane(uint32_t object_count);

}  // namespace sweepstake
