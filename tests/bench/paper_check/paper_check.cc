#include "tests/bench/paper_check/paper_check.h"

#include <algorithm>
#include <cassert>
#include <string_view>

#include "engine_client/cli/io/parallel.h"

namespace sweepstake::cli {
namespace {

constexpr double kObservationS = 900;
constexpr double kIntervalS = 2;
constexpr double kSettlingS = 2;
// Of a window below 5 FPS: no FPS and detection score, and a third of the memory's and checks'
// weights at most (reward.h).
constexpr double kStallReward = 0.068;
constexpr double kNotLearnt = 2 + 2;  // of n*: the prior and the exploration's two windows

// Five equal whole numbers have a deviation of 0, which says no more than that the mean is nearer
// to theirs than to the next.
constexpr double kMinSwitchTolerance = 0.5;

PaperCheckFigure Figure(std::string_view name, const PaperFigure& paper, double tolerance,
                        const std::vector<double>& values) {
  PaperCheckFigure figure{.name = name,
                          .paper = paper,
                          .allowed = {paper.mean - tolerance, paper.mean + tolerance},
                          .mean = Mean(values),
                          .ci95 = BootstrapMean(values)};
  figure.is_in =
      !values.empty() && figure.mean >= figure.allowed.low && figure.mean <= figure.allowed.high;
  return figure;
}

PaperCheckFigure Figure(std::string_view name, const PaperFigure& paper,
                        const std::vector<double>& values) {
  return Figure(name, paper, 2 * paper.deviation, values);
}

bool Dominates(const PaperCell& cell, const PaperGame& game) {
  return kPaperArms[game.dominant_arm] == cell.dominant;
}

std::vector<double> Column(std::span<const PaperGame> games, double PaperGame::*column) {
  std::vector<double> values;
  for (const PaperGame& game : games) values.push_back(game.*column);
  return values;
}

}  // namespace

bool PaperCheckRow::matches() const {
  return std::all_of(figures.begin(), figures.end(),
                     [](const PaperCheckFigure& figure) { return figure.is_in; });
}

double SecondsPerUpdate(const PaperCell& cell) {
  const double active_s = cell.active_percent.mean / 100 * kObservationS;
  const double settling_s = cell.switches.mean / 2 * kSettlingS;  // every other switch is to it
  return (active_s - settling_s) / (cell.evidence.mean - kNotLearnt);
}

double MeanRewardBound(const PaperCell& cell) {
  const double stalled_share =
      std::clamp((SecondsPerUpdate(cell) - kIntervalS) / (kLongestFrameS - kIntervalS), 0.0, 1.0);
  return 1 - stalled_share * (1 - kStallReward);
}

PaperCheckRow JudgePaperGames(const PaperCell& cell, const PaperCellFit& fit,
                              std::span<const PaperGame> games) {
  assert(!games.empty());
  std::vector<PaperGame> dominant;
  std::vector<double> switches;
  for (const PaperGame& game : games) {
    switches.push_back(static_cast<double>(game.switch_count));
    if (Dominates(cell, game)) dominant.push_back(game);
  }
  const double tolerance = std::max(2 * cell.switches.deviation, kMinSwitchTolerance);
  return {
      .cell = cell,
      .fit = fit,
      .dominance_ratio = static_cast<double>(dominant.size()) / static_cast<double>(games.size()),
      .figures = {Figure("switches", cell.switches, tolerance, switches),
                  Figure("active_percent", cell.active_percent,
                         Column(dominant, &PaperGame::active_percent)),
                  Figure("posterior_mean", cell.posterior_mean,
                         Column(dominant, &PaperGame::posterior_mean)),
                  Figure("evidence", cell.evidence, Column(dominant, &PaperGame::evidence))}};
}

std::vector<PaperCheckRow> CheckPaper(std::span<const PaperCell> cells,
                                      std::span<const PaperCellFit> fits,
                                      const PaperCheckOptions& options,
                                      const std::function<void(uint64_t done)>& on_game) {
  assert(cells.size() == fits.size() && options.seed_count > 0);
  const size_t seed_count = options.seed_count;
  std::vector<PaperGame> games(cells.size() * seed_count);
  RunParallel(
      games.size(), options.thread_count,
      [&](uint64_t i) { games[i] = PlayPaperGame(fits[i / seed_count], 1 + i % seed_count); },
      on_game);
  std::vector<PaperCheckRow> rows;
  for (size_t cell = 0; cell < cells.size(); ++cell) {
    rows.push_back(JudgePaperGames(cells[cell], fits[cell],
                                   std::span(games).subspan(cell * seed_count, seed_count)));
  }
  return rows;
}

}  // namespace sweepstake::cli
