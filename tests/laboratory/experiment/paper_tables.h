// Tables 3 and 4 of the paper as printed (section 7), for comparison with an experiment's results.
// Constants; safe from any thread.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "tests/laboratory/experiment/experiment_summary.h"

namespace sweepstake::cli {

struct PaperFigure {
  double mean = 0;
  double deviation = 0;  // sample standard deviation
};

// A cell of the paper's grid: 5 runs of 15 minutes.
struct PaperCell {
  std::string_view scene;  // as --scene takes it
  uint32_t object_count = 0;
  std::string_view dominance;       // Table 3's column, as "KDTree 3/5; AxisSweep 2/5"
  std::string_view interpretation;  // Table 3's
  std::string_view dominant;        // Table 4: the most frequent dominant arm
  uint32_t dominant_run_count = 0;  // of kPaperRunCount
  PaperFigure switches;             // after the exploration, over all runs
  PaperFigure active_percent;       // over the dominant runs
  PaperFigure posterior_mean;       // μ* = α ÷ (α + β), over the dominant runs
  PaperFigure evidence;             // n* = α + β, over the dominant runs
};

inline constexpr uint32_t kPaperRunCount = 5;

// Returns the cells in the paper's order.
std::span<const PaperCell> PaperCells();

// Returns null if the paper does not have this cell.
const PaperCell* FindPaperCell(std::string_view scene, uint32_t object_count);
inline const PaperCell* PaperOf(const CellSummary& summary) {
  return FindPaperCell(summary.cell.scene, summary.cell.object_count);
}

}  // namespace sweepstake::cli
