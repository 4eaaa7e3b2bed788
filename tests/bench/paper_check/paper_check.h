// Compares the policy `paper` with the paper. For each cell of its Table 4, μ* and the active share
// are fitted with the two costs of paper_game.h. The switches, n* and the dominance of Table 3 are
// then predictions of the policy, which are compared with the paper's.
//
// The same is done with the policy `random`, and with minimum numbers of samples per window, the
// same for all cells.
//
// Our runs are aggregated like the paper's five runs: switches over all of them; active share, μ*
// and n* over those in which the cell's dominant arm dominates. A difference is measured in
// standard errors of the mean of five runs (or of as many as the paper's mean has), from the mean
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
#include "tests/laboratory/experiment/experiment_summary.h"

namespace sweepstake::cli {

struct PaperResidual {
  std::string_view name;
  bool is_fitted = false;
  PaperFigure paper;
  PaperFigure ours;            // over our runs; NaN if the dominant arm never dominates
  double standard_errors = 0;  // (ours − paper) ÷ standard error; infinite if `ours` is NaN

  bool is_close() const { return -2 <= standard_errors && standard_errors <= 2; }
};

// The order of PaperPrediction::figures.
enum PaperFigureIndex : size_t { kDominance, kSwitches, kActive, kPosteriorMean, kEvidence };

struct PaperPrediction {
  PaperRules rules;
  PaperCell cell;
  PaperCosts costs;  // the fitted costs
  std::array<PaperResidual, 5> figures;
};

struct PaperCheckOptions {
  uint32_t seed_count = 100;  // runs of a prediction; a fit uses up to 50 other runs
  uint32_t thread_count = 1;
};

// The minimum numbers of samples per window that are tried.
inline constexpr std::array<uint32_t, 4> kMinSampleCounts = {20, 40, 80, 160};

// Returns `paper` as shipped, `random`, and `paper` with each of kMinSampleCounts.
std::vector<PaperRules> PaperRulesToCheck();

// Returns one prediction per rules and cell; the cells of the first rules come first. `on_done` is
// called on the calling thread with the number of finished predictions. REQUIRES: at least one
// seed.
std::vector<PaperPrediction> CheckPaper(std::span<const PaperRules> rules,
                                        std::span<const PaperCell> cells,
                                        const PaperCheckOptions& options,
                                        const std::function<void(uint64_t done)>& on_done);

// Finds the costs that give a cell's μ* and active share, or come closest to them. It increases or
// decreases one cost at a time by a factor, and shrinks the factor if neither helps. It uses 8 runs
// first, and then all.
PaperCosts FitPaperCosts(const PaperRules& rules, const PaperCell& cell, uint32_t seed_count);

// Compares the figures of some runs with those of the cell. REQUIRES: not empty.
std::array<PaperResidual, 5> CompareWithPaper(const PaperCell& cell,
                                              std::span<const PaperGame> games);

// Returns the seconds of active time (without settling) per observation in the paper's n*: 2 if
// every tick was an observation.
double SecondsPerObservation(const PaperCell& cell);

// The number of predicted figures that are close, and their root mean square distance in standard
// errors, with each distance limited to 10.
struct PaperScore {
  uint32_t close_count = 0;
  uint32_t figure_count = 0;
  double distance = 0;
};
PaperScore ScoreOf(std::span<const PaperPrediction> predictions);

}  // namespace sweepstake::cli
