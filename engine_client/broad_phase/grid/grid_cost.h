// Estimates the cost of a search over groups of boxes, and joins shape classes into
// groups while that lowers it.
//
// Pure functions. The time depends on the number of shape classes, not on the number of boxes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "engine_client/broad_phase/grid/grid_measure.h"
#include "engine_client/broad_phase/grid/group_grid.h"

namespace sweepstake {

constexpr size_t kMaxGridGroups = 8;

// Joins the known shape classes (bit c of known_classes is class c) into at most kMaxGridGroups
// groups. If bit h of searches[g] is set, the boxes of group g search the grid of group h. Unknown
// classes belong to the first group. Returns the number of groups. REQUIRES: at least one class is
// known.
size_t ChooseGroups(const CornerBounds& bounds, const GridMeasure& measure, uint64_t known_classes,
                    uint32_t (&group_of_class)[ShapeClasses::kCount],
                    std::array<uint32_t, kMaxGridGroups>& searches);

}  // namespace sweepstake
