// What a search over groups of boxes would cost, and the groups for which that is least.
//
// Pure functions. Cost: 1 µs for one class of shape, up to 0.3 ms for many.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "engine_client/broad_phase/grid/grid_measure.h"
#include "engine_client/broad_phase/grid/group_grid.h"

namespace sweepstake {

constexpr size_t kMostGridGroups = 8;

// Joins the known classes (a bit each) to at most kMostGridGroups groups, and
// says of each group into which others its boxes look. Classes that are not known join the group of
// the first. Returns the number of groups. REQUIRES: a class is known.
size_t ChooseGroups(const CornerBounds& bounds, const GridMeasure& measure, uint64_t known_classes,
                    uint32_t (&group_of_class)[ShapeClasses::kCount],
                    std::array<uint32_t, kMostGridGroups>& looks_into);

}  // namespace sweepstake
