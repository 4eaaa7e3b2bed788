// Compares the policy `paper` with the paper. For each cell of the paper's Table 4, the two costs
// of paper_game.h are fitted to μ* and the active share. With these costs the policy predicts the
// switches, n* and the dominance of Table 3. The predictions are compared with the paper's figures.
//
// The same is done with the policy `random`, and with the policy `paper` and a minimum number of
// samples per window that is the same for all cells.
//
// Our runs are averaged like the paper's five runs: the switches over all runs; the active share,
// μ* and n* over the runs in which the cell's dominant arm dominates. Differences are measured in
// standard errors of the paper's mean, a mean of at most five runs. The variance of a run is
// assumed to be the mean of the paper's and our variance.
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
  Spread paper;
  Spread ours;                 // over our runs; NaN if the dominant arm never dominates
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

// Returns one prediction for each pair of rules and cell, with all cells of the first rules first.
// `on_done` is called on the calling thread with the number of finished predictions. REQUIRES: at
// least one seed.
std::vector<PaperPrediction> CheckPaper(std::span<const PaperRules> rules,
                                        std::span<const PaperCell> cells,
                                        const PaperCheckOptions& options,
                                        const std::function<void(uint64_t done)>& on_done);

// Finds the costs that give a cell's μ* and active share, or come closest to them. Increases or
// decreases one cost at a time by a factor, and reduces the factor if neither helps. A trial of two
// costs has at most 8 runs at first, and later `seed_count` runs.
PaperCosts FitPaperCosts(const PaperRules& rules, const PaperCell& cell, uint32_t seed_count);

// Compares our runs `games` with the paper's figures of the cell. REQUIRES: `games` is not empty.
std::array<PaperResidual, 5> CompareWithPaper(const PaperCell& cell,
                                              std::span<const PaperGame> games);

// Returns the seconds of active time (without settling) per observation in the paper's n*. The
// result is 2 if every tick was an observation.
double SecondsPerObservation(const PaperCell& cell);

// The number of predicted figures that are close (is_close), and the root mean square distance of
// all predicted figures in standard errors. Each distance is limited to 10.
struct PaperScore {
  uint32_t close_count = 0;
  uint32_t figure_count = 0;
  double distance = 0;
};
PaperScore ScoreOf(std::span<const PaperPrediction> predictions);

}  // namespace sweepstake::cli
