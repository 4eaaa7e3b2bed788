// Which axis a sweep should run along.
#pragma once

#include <span>

#include "sweepstake/aabb.h"

namespace sweepstake {

// The axis on which the centres of the boxes that take part vary most, 0 to 2; 0 when there are
// none. Reads at most 4,096 boxes, evenly spread over the indices: more would cost what a better
// choice saves.
int AxisOfLargestSpread(std::span<const Aabb> boxes);

}  // namespace sweepstake
