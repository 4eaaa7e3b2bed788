// Is the policy `paper` the paper's? Of each cell of its Table 4, μ* and the active share are
// fitted, by the two costs of paper_game.h; what the policy then does is a prediction of the
// switches, of n* and of Table 3's dominance, to be compared with the paper's.
//
// The same is done with the policy `random`, and with least numbers of samples per window, of which
// one holds for all cells.
//
// Our runs are aggregated as the paper's five are: switches over all of them, active share, μ* and
// n* over those in which the cell's dominant arm dominates. A difference is measured by the
// standard error of the mean of five runs, or of as many as the paper's mean is over, from the mean
// of the paper's and our variance.
//
// Deterministic; the result does not depend on the number of threads.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "tests/bench/paper_check/paper_game.h"
#include "tests/laboratory/experiment/paper_tables.h"

namespace sweepstake::cli {

struct PaperResidual {
  std::string_view name;
  bool is_fitted = false;
  PaperFigure paper;
  PaperFigure ours;            // over our runs; not a number if the dominant arm never dominates
  double standard_errors = 0;  // (ours − paper) ÷ standard error; infinite if it never dominates

  bool is_close() const { return -2 <= standard_errors && standard_errors <= 2; }
};

// The places of the figures.
enum PaperFigureIndex : size_t { kDominance, kSwitches, kActive, kPosteriorMean, kEvidence };

struct PaperPrediction {
  PaperRules rules;
  PaperCell cell;
  PaperCosts costs;  // fitted
  std::array<PaperResidual, 5> figures;
};

struct PaperCheckOptions {
  uint32_t seed_count = 100;  // runs of a prediction; a fit takes as many, others, to 50
  uint32_t thread_count = 1;
};

// The least numbers of samples per window that are tried.
inline constexpr std::array<uint32_t, 4> kMinSampleCounts = {20, 40, 80, 160};

// `paper` as it ships, `random`, and `paper` with each of kMinSampleCounts.
std::vector<PaperRules> PaperRulesToCheck();

// Returns one prediction per rules and cell, all cells of the first rules first. `on_done` hears
// from the calling thread how many there are. REQUIRES: at least one seed.
std::vector<PaperPrediction> CheckPaper(std::span<const PaperRules> rules,
                                        std::span<const PaperCell> cells,
                                        const PaperCheckOptions& options,
                                        const std::function<void(uint64_t done)>& on_done);

// Finds the costs that give a cell's μ* and active share, or come closest to them: one after
// the other is made larger and smaller by a factor, which shrinks when none helps; first with 8
// runs, then with all.
PaperCosts FitPaperCosts(const PaperRules& rules, const PaperCell& cell, uint32_t seed_count);

// The figures of some runs beside the cell's. REQUIRES: not empty.
std::array<PaperResidual, 5> CompareWithPaper(const PaperCell& cell,
                                              std::span<const PaperGame> games);

// Seconds of active time, settling left out, that the paper's n* took for each of its observations:
// 2 where every tick taught something.
double SecondsPerObservation(const PaperCell& cell);

// The predicted figures of some cells that are close, and the root of their mean squared distance
// in standard errors, each counted as 10 at most.
struct PaperScore {
  uint32_t close_count = 0;
  uint32_t figure_count = 0;
  double distance = 0;
};
PaperScore ScoreOf(std::span<const PaperPrediction> predictions);

}  // namespace sweepstake::cli
