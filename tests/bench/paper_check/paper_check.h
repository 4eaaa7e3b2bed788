// The paper's own numbers against the real decision core: with costs of the arms that were fitted
// to a cell of Table 4, does the policy `paper` give its switches, active share, μ* and n*
// together?
//
// Many runs per cell, aggregated as Table 4 aggregates five: switches over all runs, the rest over
// those in which the cell's dominant arm dominates. A figure is in when its mean lies within the
// paper's mean ± 2 standard deviations. Pure but for its threads; the result does not depend on
// their number. Cost: some 5 ms per run and core.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "engine_client/cli/experiment/paper_tables.h"
#include "engine_client/cli/io/statistics.h"
#include "tests/bench/paper_check/paper_game.h"

namespace sweepstake::cli {

struct PaperCheckFigure {
  std::string_view name;  // "switches", "active_percent", "posterior_mean", "evidence"
  PaperFigure paper;
  Interval allowed;  // by the paper
  double mean = 0;
  Interval ci95;  // over our runs
  bool is_in = false;
};

struct PaperCheckRow {
  PaperCell cell;
  PaperCellFit fit;
  double dominance_ratio = 0;  // share of our runs in which the cell's dominant arm dominates
  std::array<PaperCheckFigure, 4> figures;

  bool matches() const;
};

// Seconds of active time, settling left out, that the paper's n* took for each of its observations:
// 2 where every tick taught something. More than the 5 s that a frame may last at most cannot be.
double SecondsPerUpdate(const PaperCell& cell);

// The mean reward above which no share of windows could lie if the time beyond 2 s per update had
// gone into frames of up to 5 s, which are windows of their own and score next to nothing.
double MeanRewardBound(const PaperCell& cell);

inline constexpr double kLongestFrameS = 5;  // a longer one is a bail-out

struct PaperCheckOptions {
  uint32_t seed_count = 100;
  uint32_t thread_count = 1;
};

// One fit per cell, in order. `on_game` hears from the calling thread how many runs are done.
// REQUIRES: as many cells as fits, at least one seed.
std::vector<PaperCheckRow> CheckPaper(std::span<const PaperCell> cells,
                                      std::span<const PaperCellFit> fits,
                                      const PaperCheckOptions& options,
                                      const std::function<void(uint64_t done)>& on_game);

// The row of a cell from its runs. REQUIRES: there is one.
PaperCheckRow JudgePaperGames(const PaperCell& cell, const PaperCellFit& fit,
                              std::span<const PaperGame> games);

}  // namespace sweepstake::cli
