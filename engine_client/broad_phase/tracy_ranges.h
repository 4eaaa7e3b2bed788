// Which cells of a grid a box reaches into: a pure function of the box and the layout.
//
// Values; the kernel is chosen at run time once per call.
#pragma once

#include <cstddef>
#include <cstdint>

#include "engine_client/broad_phase/grid_layout.h"
#include "engine_client/broad_phase/soa_boxes.h"

namespace sweepstake {

// First and last cell, by number: x + cells_x · (y + cells_y · z).
struct CellRange {
  // In `first`, for a box in no cell.
  static constexpr uint32_t kAbsent = 0xFFFFFFFF;
  static constexpr uint32_t kLarge = 0xFFFFFFFE;
  // More cells than this make a box large.
  static constexpr int32_t kMostCells = 64;

  uint32_t first;
  uint32_t last;

  bool IsInCells() const { return first < kLarge; }
  friend bool operator==(const CellRange&, const CellRange&) = default;
};

struct CellPosition {
  uint32_t at[3];
};

inline CellPosition PositionOf(const GridLayout& layout, uint32_t cell) {
  const uint32_t row = cell / layout.cells[0];
  return {{cell % layout.cells[0], row % layout.cells[1], row / layout.cells[1]}};
}

inline uint32_t NumberOf(const GridLayout& layout, const CellPosition& position) {
  return position.at[0] + layout.cells[0] * (position.at[1] + layout.cells[1] * position.at[2]);
}

inline size_t CellCount(const GridLayout& layout) {
  return size_t{layout.cells[0]} * layout.cells[1] * layout.cells[2];
}

// Ranges of all lanes; writes up to SoaBoxes::kPadding more.
void FindRanges(const BoxLanes& lanes, const GridLayout& layout, CellRange* ranges);

}  // namespace sweepstake
