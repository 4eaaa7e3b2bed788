// The uniform grid of the Grid and Tracy families: how fine it is, where it lies, and which cell a
// coordinate is in.
//
// A cell number is a monotone function of the coordinate, clamped to the grid: that alone makes the
// searches built on it sound, whatever rounding, overflow and outliers do. Coordinates are halved
// inside, so that no difference of two finite floats overflows. Boxes that do not take part are
// sentinels (soa_boxes.h) and count nowhere.
//
// Values, safe to copy. Cost: MeasureSpread O(n), about 1 ns per box; the rest does not depend on
// n.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "engine_client/broad_phase/soa_boxes.h"

namespace sweepstake {

// What a grid is laid out from.
struct BoxSpread {
  // Sizes by the leading bits of the float, eight classes per octave: the classes of one frame fit
  // the first cache.
  static constexpr uint32_t kSideClasses = 2048;
  static constexpr int kSideClassShift = 20;

  size_t count = 0;  // boxes that take part
  float low[3];      // bounds of the min corners; meaningless when count is 0
  float high[3];
  float longest_side = 0;  // over boxes and axes; at most the largest float
  std::array<uint32_t, kSideClasses> side_counts{};  // boxes by their longest side
};

struct GridLayout {
  float origin[3] = {};        // half the coordinate at which cell 0 starts
  float scale[3] = {1, 1, 1};  // cells per half unit
  uint32_t cells[3] = {1, 1, 1};

  // One empty cell around the grid on every side lets a search read the neighbours of any cell.
  size_t row_cells() const { return cells[0] + 2; }
  size_t slab_cells() const { return row_cells() * (cells[1] + 2); }
  size_t bordered_cells() const { return slab_cells() * (cells[2] + 2); }

  // REQUIRES: `coordinate` is finite.
  uint32_t CellOf(float coordinate, int axis) const;
};

// Fills `spread`, classes included.
void MeasureSpread(const BoxLanes& lanes, BoxSpread& spread);

// The longest side below which a box is ordinary, by the estimated number of lane comparisons: an
// ordinary box meets the 13.5 cells around it, a larger one every box.
float ChooseOrdinarySide(const BoxSpread& spread);

// Cells of at least `side` over the min corners, fewer and larger where more than `max_cells`
// (border included, at least 512) would be needed. Where outliers would make the cells too large,
// they are clamped into the outermost cells.
GridLayout LayOutGrid(const BoxLanes& lanes, const BoxSpread& spread, float side, size_t max_cells);

}  // namespace sweepstake
