// Estimates from a sample of the boxes how well grids fit a scene.
//
// Plain values and pure functions. Cost: BoxesPerCell about 2 µs, SearchTests about 20 µs.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/grid/grid_sort.h"
#include "engine_client/broad_phase/grid/group_grid.h"
#include "sweepstake/aabb.h"

namespace sweepstake {

// Grids and the groups of boxes that they belong to, as in GridPlan.
struct SampledGrids {
  std::span<const GroupGrid> grids;
  const GroupChoice& choice;
  const uint32_t* searches;
};

// A sample of the valid boxes. `draws` is the number of boxes that are drawn, at most kMaxCount.
struct BoxSample {
  static constexpr size_t kMaxCount = 256;

  std::array<Aabb, kMaxCount> boxes;
  size_t count = 0;      // the number of valid boxes among the drawn ones
  size_t all_count = 0;  // the number of boxes that the sample stands for

  BoxSample(std::span<const Aabb> all, size_t draws);
  std::span<const Aabb> span() const { return {boxes.data(), count}; }
};

// The following functions use only the first kEstimateCount boxes of a sample, because the cost of
// SearchTests is quadratic.
constexpr size_t kEstimateCount = 96;

// Returns the mean number of boxes with which a box shares its cell, or 0 if the sample has too few
// such boxes for an estimate.
double BoxesPerCell(const BoxSample& sample, const SampledGrids& grids);

// Returns the mean cost of a search for a box's pairs, in tests of a box: it reads rows of cells
// and tests the boxes in them.
double SearchTests(const BoxSample& sample, const SampledGrids& grids);

}  // namespace sweepstake
