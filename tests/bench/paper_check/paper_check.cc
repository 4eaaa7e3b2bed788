#include "tests/bench/paper_check/paper_check.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "engine_client/cli/io/statistics.h"
#include "tests/laboratory/io/parallel.h"

namespace sweepstake::cli {
namespace {

constexpr uint32_t kMaxFitSeedCount = 50;

uint32_t ArmOf(const PaperCell& cell) {
  const auto arm = std::find(kPaperArms.begin(), kPaperArms.end(), cell.dominant);
  return static_cast<uint32_t>(arm - kPaperArms.begin());
}

std::vector<PaperGame> Play(const PaperRules& rules, const PaperCell& cell, const PaperCosts& costs,
                            uint64_t first_seed, uint32_t seed_count) {
  std::vector<PaperGame> games;
  for (uint64_t seed = first_seed; seed < first_seed + seed_count; ++seed)
    games.push_back(PlayPaperGame(rules, costs, ArmOf(cell), seed));
  return games;
}

// `deviation` is the standard deviation of the figure between runs.
PaperResidual Compare(std::string_view name, const Spread& paper, const Spread& ours,
                      double deviation, uint32_t run_count) {
  const double error = deviation / std::sqrt(static_cast<double>(run_count));
  const double difference = ours.mean - paper.mean;
  return {name, false, paper, ours, difference == 0 ? 0 : difference / error};
}

double Squared(double x) { return x * x; }

PaperResidual Compare(std::string_view name, const Spread& paper, const std::vector<double>& values,
                      uint32_t run_count) {
  if (values.empty()) {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    return {name, false, paper, {kNone, kNone}, std::numeric_limits<double>::infinity()};
  }
  const Spread ours{Mean(values), SampleDeviation(values)};
  const double pooled = std::sqrt((Squared(paper.deviation) + Squared(ours.deviation)) / 2);
  return Compare(name, paper, ours, pooled, run_count);
}

// The paper gives no deviation of its counts. For our deviation one run of each kind is added
// (Laplace), because a share of 1 would have a deviation of 0.
PaperResidual CompareDominance(uint32_t dominant_run_count, std::vector<double> values) {
  const Spread paper{static_cast<double>(dominant_run_count) / kPaperRunCount, 0};
  const Spread ours{Mean(values), SampleDeviation(values)};
  values.insert(values.end(), {0, 1});
  return Compare("dominance", paper, ours, SampleDeviation(values), kPaperRunCount);
}

// The loss of the fitted figures, in standard errors of the paper's runs alone. If the errors of
// our runs were included, the fit would prefer costs that make our runs differ.
double LossOf(const std::array<PaperResidual, 5>& figures, uint32_t run_count) {
  double loss = 0;
  for (const PaperResidual& figure : figures) {
    if (!figure.is_fitted) continue;
    if (std::isnan(figure.ours.mean)) return std::numeric_limits<double>::infinity();
    loss += Squared((figure.ours.mean - figure.paper.mean) / figure.paper.deviation) * run_count;
  }
  return loss;
}

class Fit {
 public:
  Fit(const PaperRules& rules, const PaperCell& cell, const PaperCosts& start, uint32_t seed_count)
      : rules_(rules), cell_(cell), seed_count_(seed_count), best_(start), loss_(LossAt(start)) {}

  PaperCosts Run(double factor) {
    constexpr double kLastFactor = 1.02;
    constexpr double kGoodEnough = 0.1;
    while (factor > kLastFactor && loss_ > kGoodEnough)
      if (!Round(factor)) factor = std::sqrt(factor);
    return best_;
  }

 private:
  bool Round(double factor) {
    bool any = false;
    for (const double step : {factor, 1 / factor}) any |= Move(step, 1) || Move(1, step);
    return any;
  }

  bool Move(double detection_factor, double gap_factor) {
    const PaperCosts costs{best_.detection_ms * detection_factor, best_.gap_ms * gap_factor};
    const double loss = LossAt(costs);
    if (loss >= loss_) return false;
    best_ = costs;
    loss_ = loss;
    return true;
  }

  double LossAt(const PaperCosts& costs) const {
    return LossOf(CompareWithPaper(cell_, Play(rules_, cell_, costs, 1, seed_count_)),
                  cell_.dominant_run_count);
  }

  const PaperRules& rules_;
  const PaperCell& cell_;
  const uint32_t seed_count_;
  PaperCosts best_;
  double loss_;
};

}  // namespace

std::vector<PaperRules> PaperRulesToCheck() {
  std::vector<PaperRules> rules = {{.policy = "paper"}, {.policy = "random"}};
  for (const uint32_t count : kMinSampleCounts)
    rules.push_back({.policy = "paper", .min_sample_count = count});
  return rules;
}

std::vector<PaperPrediction> CheckPaper(std::span<const PaperRules> rules,
                                        std::span<const PaperCell> cells,
                                        const PaperCheckOptions& options,
                                        const std::function<void(uint64_t done)>& on_done) {
  assert(options.seed_count > 0);
  const uint32_t fit_seed_count = std::min(options.seed_count, kMaxFitSeedCount);
  std::vector<PaperPrediction> predictions(rules.size() * cells.size());
  const auto predict = [&](uint64_t i) {
    PaperPrediction& prediction = predictions[i];
    prediction.rules = rules[i / cells.size()];
    prediction.cell = cells[i % cells.size()];
    prediction.costs = FitPaperCosts(prediction.rules, prediction.cell, fit_seed_count);
    prediction.figures =
        CompareWithPaper(prediction.cell, Play(prediction.rules, prediction.cell, prediction.costs,
                                               1 + fit_seed_count, options.seed_count));
  };
  RunParallel(predictions.size(), options.thread_count, predict, on_done);
  return predictions;
}

PaperCosts FitPaperCosts(const PaperRules& rules, const PaperCell& cell, uint32_t seed_count) {
  const PaperCosts coarse =
      Fit(rules, cell, {.detection_ms = 4, .gap_ms = 4}, std::min(seed_count, 8U)).Run(2);
  return Fit(rules, cell, coarse, seed_count).Run(1.2);
}

std::array<PaperResidual, 5> CompareWithPaper(const PaperCell& cell,
                                              std::span<const PaperGame> games) {
  assert(!games.empty());
  std::vector<double> dominance, switches, active, mean, evidence;
  for (const PaperGame& game : games) {
    switches.push_back(static_cast<double>(game.switch_count));
    dominance.push_back(game.dominant_arm == ArmOf(cell) ? 1 : 0);
    if (dominance.back() == 0) continue;
    active.push_back(game.active_percent);
    mean.push_back(game.posterior_mean);
    evidence.push_back(game.evidence);
  }
  const uint32_t runs = cell.dominant_run_count;
  std::array<PaperResidual, 5> figures = {
      CompareDominance(runs, dominance),
      Compare("switches", cell.switches, switches, kPaperRunCount),
      Compare("active_percent", cell.active_percent, active, runs),
      Compare("posterior_mean", cell.posterior_mean, mean, runs),
      Compare("evidence", cell.evidence, evidence, runs)};
  figures[kActive].is_fitted = figures[kPosteriorMean].is_fitted = true;
  return figures;
}

double SecondsPerObservation(const PaperCell& cell) {
  constexpr double kObservationS = 900;
  constexpr double kSettlingS = 2;
  constexpr double kNotLearnt = 2 + 2;  // part of n* from the prior and the exploration's windows
  const double active_s = cell.active_percent.mean / 100 * kObservationS;
  // Assumes that every second switch leads to the dominant arm, which must then settle.
  const double settling_s = cell.switches.mean / 2 * kSettlingS;
  return (active_s - settling_s) / (cell.evidence.mean - kNotLearnt);
}

PaperScore ScoreOf(std::span<const PaperPrediction> predictions) {
  constexpr double kMaxDistance = 10;
  PaperScore score;
  double sum = 0;
  for (const PaperPrediction& prediction : predictions) {
    for (const PaperResidual& figure : prediction.figures) {
      if (figure.is_fitted) continue;
      ++score.figure_count;
      score.close_count += figure.is_close() ? 1 : 0;
      sum += Squared(std::min(std::abs(figure.standard_errors), kMaxDistance));
    }
  }
  score.distance = std::sqrt(sum / std::max(score.figure_count, 1U));
  return score;
}

}  // namespace sweepstake::cli
