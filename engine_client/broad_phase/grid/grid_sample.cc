#include "engine_client/broad_phase/grid/grid_sample.h"

#include <algorithm>

#include "engine_client/broad_phase/common/coordinate_range.h"
#include "engine_client/broad_phase/grid/grid_search.h"

namespace sweepstake {
namespace {

// Fewer sampled pairs than this in one cell may be chance.
constexpr size_t kMinPairsInCell = 8;

uint32_t GroupOf(const Aabb& box, const GroupChoice& choice) {
  uint32_t shape_class = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const float side = 0.5F * box.max[axis] - 0.5F * box.min[axis];
    shape_class |= choice.classes.StepOf(side) << (ShapeClasses::kBitsPerAxis * axis);
  }
  return choice.group_of_class[shape_class];
}

// The cells of a grid from `first` to `last` on each axis.
struct CellBlock {
  uint32_t first[3];
  uint32_t last[3];

  double RowCount(const GroupGrid& grid) const {
    double rows = 1;
    for (const int across : {1, 2}) {
      const size_t axis = grid.AxisOf(across);
      rows *= last[axis] - first[axis] + 1;
    }
    return rows;
  }
  bool Contains(const uint32_t (&cell)[3]) const {
    for (int axis = 0; axis < 3; ++axis) {
      if (cell[axis] < first[axis] || cell[axis] > last[axis]) return false;
    }
    return true;
  }
};

// Returns the cells that can hold the min corners of the box's partners.
CellBlock BlockOf(const Aabb& box, const GroupGrid& grid) {
  CellBlock block{};
  for (int axis = 0; axis < 3; ++axis) {
    block.first[axis] = grid.CellAt(axis, 0.5F * box.min[axis] - grid.reach[axis]);
    block.last[axis] = grid.CellAt(axis, 0.5F * box.max[axis]);
  }
  return block;
}

struct SampledBox {
  uint32_t group;
  uint32_t cell[3];  // the cell of the min corner in the grid of the group
};

// Finds the cells of the boxes that an estimate uses.
struct SampledCells {
  std::array<SampledBox, kEstimateCount> boxes;
  size_t count;

  SampledCells(const BoxSample& sample, const SampledGrids& grids)
      : count(std::min(sample.count, kEstimateCount)) {
    for (size_t k = 0; k < count; ++k) {
      const Aabb& box = sample.boxes[k];
      boxes[k].group = GroupOf(box, grids.choice);
      const GroupGrid& grid = grids.grids[boxes[k].group];
      for (int axis = 0; axis < 3; ++axis)
        boxes[k].cell[axis] = grid.CellAt(axis, 0.5F * box.min[axis]);
    }
  }
};

}  // namespace

BoxSample::BoxSample(std::span<const Aabb> all, size_t draws) : all_count(all.size()) {
  draws = std::min(draws, all.size());
  for (size_t k = 0; k < draws; ++k) {
    const Aabb& box = all[DrawIndex(k, all.size())];
    if (IsValid(box)) boxes[count++] = box;
  }
}

double BoxesPerCell(const BoxSample& sample, const SampledGrids& grids) {
  const SampledCells found(sample, grids);
  std::array<uint32_t, kEstimateCount> cells;
  for (size_t k = 0; k < found.count; ++k) {
    const GroupGrid& grid = grids.grids[found.boxes[k].group];
    cells[k] = grid.first_cell;
    for (int axis = 0; axis < 3; ++axis) cells[k] += found.boxes[k].cell[axis] * grid.stride[axis];
  }
  std::sort(cells.begin(), cells.begin() + found.count);
  size_t pairs = 0;
  for (size_t begin = 0; begin < found.count;) {
    size_t end = begin + 1;
    while (end < found.count && cells[end] == cells[begin]) ++end;
    pairs += (end - begin) * (end - begin - 1) / 2;
    begin = end;
  }
  if (pairs < kMinPairsInCell) return 0;
  const auto count = static_cast<double>(found.count);
  return 2 * static_cast<double>(pairs * sample.all_count) / (count * count);
}

double SearchTests(const BoxSample& sample, const SampledGrids& grids) {
  const SampledCells found(sample, grids);
  double tests = 0;
  double row_tests = 0;
  for (size_t k = 0; k < found.count; ++k) {
    const uint32_t own = found.boxes[k].group;
    for (uint32_t group = 0; group < grids.grids.size(); ++group) {
      if (group != own && (grids.searches[own] >> group & 1) == 0) continue;
      const CellBlock block = BlockOf(sample.boxes[k], grids.grids[group]);
      // In its own group a box searches only half of the block.
      const double weight = group == own ? 0.5 : 1;
      row_tests += weight * kTestsPerRow * block.RowCount(grids.grids[group]);
      for (size_t other = 0; other < found.count; ++other) {
        const SampledBox& box = found.boxes[other];
        if (other != k && box.group == group && block.Contains(box.cell)) tests += weight;
      }
    }
  }
  const auto count = static_cast<double>(std::max<size_t>(found.count, 1));
  return tests * static_cast<double>(sample.all_count) / (count * count) + row_tests / count;
}

}  // namespace sweepstake
