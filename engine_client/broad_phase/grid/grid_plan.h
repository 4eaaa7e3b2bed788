// Plans the groups of boxes that share a grid. Boxes of a group have similar shapes, so that
// neither a few huge boxes nor long thin ones enlarge the cells of the others.
//
// If a sample of the boxes shows that many of them share a cell, and that stretched axes spread
// them over more cells, the grids belong to stretched boxes. This is checked every 32 frames, and
// after a crowd was found, every 256 frames.
//
// A plan is made from the boxes of one frame and used until a box of another shape class appears. A
// plan that no longer fits makes the search slower, but never wrong. The grids are made again in
// each frame.
//
// Not thread-safe. Owns its memory: 24 bytes per box with stretched axes. Cost: O(n) to measure the
// boxes; the time for a new plan depends only on the number of shape classes.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/common/aligned_buffer.h"
#include "engine_client/broad_phase/grid/axis_stretch.h"
#include "engine_client/broad_phase/grid/grid_cost.h"
#include "engine_client/broad_phase/grid/grid_measure.h"
#include "engine_client/broad_phase/grid/grid_sample.h"
#include "engine_client/broad_phase/grid/grid_sort.h"
#include "engine_client/broad_phase/grid/group_grid.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/executor.h"

namespace sweepstake {

class GridPlan {
 public:
  static constexpr size_t kMaxGroups = kMaxGridGroups;

  // Drops the plan: the next MakeGrids makes a new one.
  void Reset();
  // Measures the boxes, makes a new plan if the present one does not fit them, and makes the grids.
  // Returns the boxes as InGrids does. Polls `stop`, which may be null; after a stop the grids are
  // unusable.
  GridBoxes MakeGrids(Executor* executor, std::span<const Aabb> boxes, StopRequest* stop = nullptr);
  // Returns the boxes, also in the coordinates of the grids: a copy if the axes are stretched. The
  // copy is valid until the next call. Polls `stop`, as MakeGrids does.
  GridBoxes InGrids(Executor* executor, std::span<const Aabb> boxes, StopRequest* stop = nullptr);

  std::span<const GroupGrid> grids() const { return {grids_.data(), group_count_}; }
  const GroupChoice& choice() const { return choice_; }
  // If bit h of searches()[g] is set, boxes of group g search the grid of group h for pairs.
  const uint32_t* searches() const { return searches_.data(); }
  size_t native_bytes() const { return stretched_.capacity_bytes(); }

 private:
  bool MakeGridsOf(Executor* executor, std::span<const Aabb> boxes, bool is_check_due,
                   StopRequest* stop);
  GridBoxes StretchIfCrowded(Executor* executor, std::span<const Aabb> boxes, StopRequest* stop);
  void MakeGridsOfSample(const BoxSample& sample);
  bool UpdateThreshold(std::span<const Aabb> boxes, const GridMeasure& measure);
  bool Fits(const GridMeasure& measure) const;
  void Plan(const GridMeasure& measure);
  void LayOut(std::span<const Aabb> boxes, const GridMeasure& measure);

  GroupChoice choice_{};
  uint64_t known_classes_ = 0;  // the classes that the plan covers, one bit each
  size_t group_count_ = 0;
  uint32_t frame_ = 0;
  std::array<GroupGrid, kMaxGroups> grids_{};
  std::array<uint32_t, kMaxGroups> searches_{};
  bool is_stretched_ = false;
  uint32_t skipped_checks_ = 0;
  AxisStretch stretch_;
  AlignedBuffer<Aabb> stretched_;
};

}  // namespace sweepstake
