// Which boxes share a grid: groups of alike shapes, so that neither a few huge boxes nor long thin
// ones make the cells of the others large.
//
// A plan is made from the boxes of one frame and serves while boxes of the same shapes are all
// there are; it is never wrong, only slower where it does not fit. Grids are made each frame.
//
// Not thread-safe. Owns its memory. Cost: Grids below 2 µs per group; a new plan 1 µs where all
// boxes are of one class, up to 0.3 ms where they are of many.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/grid/grid_cost.h"
#include "engine_client/broad_phase/grid/grid_measure.h"
#include "engine_client/broad_phase/grid/grid_sort.h"
#include "engine_client/broad_phase/grid/group_grid.h"
#include "sweepstake/executor.h"

namespace sweepstake {

class GridPlan {
 public:
  static constexpr size_t kMostGroups = kMostGridGroups;

  // Nothing planned: the next MakeGrids plans.
  void Reset();
  // Measures the boxes, plans anew where the plan does not fit them, and makes the grids.
  void MakeGrids(Executor* executor, std::span<const Aabb> boxes);

  std::span<const GroupGrid> grids() const { return {grids_.data(), group_count_}; }
  const GroupChoice& choice() const { return choice_; }
  // Bit h of looks_into()[g]: of the pairs of groups g and h, boxes of g look for those of h.
  const uint32_t* looks_into() const { return looks_into_.data(); }

 private:
  bool WantsOtherClasses(std::span<const Aabb> boxes, const GridMeasure& measure);
  bool Fits(const GridMeasure& measure) const;
  void Plan(const GridMeasure& measure);
  void LayOut(std::span<const Aabb> boxes, const GridMeasure& measure);

  GroupChoice choice_{};
  uint64_t known_classes_ = 0;  // bit per class that the plan knows of
  size_t group_count_ = 0;
  uint32_t frame_ = 0;
  std::array<GroupGrid, kMostGroups> grids_{};
  std::array<uint32_t, kMostGroups> looks_into_{};
};

}  // namespace sweepstake
