// Costs of the arms with which the policy `paper` gives a cell of the paper's Table 4: the table
// that is checked in, and the search that found it.
//
// The paper prints no arm's costs. A cell's four figures determine four things at most, so a fit
// has no more: how long detection takes on the dominant arm (it sets μ*), by how much the others
// are slower (it sets switches and active share, and with them n*), where Table 3 names a second
// arm, by how much that one is, and in the two cells that ran below the stall how much time is
// lost, and in pieces of what length. All other arms are alike, since nothing printed tells them
// apart; the rest of the frame is 12 ms (100 ms where μ* is below ½: 7 FPS), the noise 1 %.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "engine_client/cli/experiment/paper_tables.h"
#include "tests/bench/paper_check/paper_check.h"
#include "tests/bench/paper_check/paper_game.h"

namespace sweepstake::cli {

struct PaperFitPoint {
  double detection_ms = 0;   // of the dominant arm
  double gap_ms = 0;         // by which the others' detection takes longer
  double second_gap_ms = 0;  // by which that of Table 3's second arm does; 0: there is none
  double rest_ms = 12;       // of the frame, whatever the arm
  double stall_ratio = 0;
  double stall_period_s = 200;
};

inline constexpr uint32_t kFitSeedCount = 50;  // runs per point of a search

PaperCellFit ExpandFit(const PaperCell& cell, const PaperFitPoint& point);

// The checked-in points, one per cell of the paper, in its order.
std::span<const PaperFitPoint> FittedPoints();
// The same, expanded.
std::vector<PaperCellFit> PaperFits();

// How far a row is from the paper: the fourth powers of the distances, each measured by what is
// allowed, summed over the four figures and the dominance. Below 1: all are in.
double FitLoss(const PaperCheckRow& row);

// Finds a point anew, from a start that only the cell's figures determine: one parameter after the
// other is made larger and smaller by a factor, which shrinks when none helps. Deterministic.
// `on_try` hears after every point tried; some 50 to 400 are.
PaperFitPoint FindFit(const PaperCell& cell, const PaperCheckOptions& options,
                      const std::function<void()>& on_try);

}  // namespace sweepstake::cli
