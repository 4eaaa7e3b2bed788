#include "tests/bench/paper_check/paper_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "tests/bench/paper_check/paper_check.h"

namespace sweepstake::cli {
namespace {

constexpr double kNoiseRatio = 0.01;

// The points that FindFit reached with kFitSeedCount runs per point. `paper_check --refit` searches
// for them anew; where the loss is flat, it may end in other points that fit as well.
constexpr std::array<PaperFitPoint, 9> kPoints = {{
    {0.4217, 0.9264, 0, 12, 0, 200},
    {0.7502, 4.8, 0, 12, 0, 200},
    {5.668, 4.8, 1.265, 12, 0, 200},
    {4.743, 3.374, 0.2746, 12, 0, 200},
    {11.87, 19.66, 0, 12, 0.399, 200},
    {48.0, 617.9665, 0, 100, 0.4345, 320},
    {0.7456, 0.7324, 0, 12, 0, 200},
    {1.634, 12.29, 0, 12, 0, 200},
    {9.683, 14.66, 0, 12, 0, 200},
}};

std::optional<std::string_view> SecondArm(const PaperCell& cell) {
  for (const std::string_view arm : kPaperArms) {
    if (arm != cell.dominant && cell.dominance.find(arm) != std::string_view::npos) return arm;
  }
  return std::nullopt;
}

// More time per observation than Δt with its settling and slow frames can account for.
bool RanBelowTheStall(const PaperCell& cell) { return SecondsPerUpdate(cell) > 3; }

PaperFitPoint StartOf(const PaperCell& cell) {
  constexpr double kMaxMean = 0.985;             // what memory, checks and noise leave
  constexpr double kMsPerReward = 16.67 / 0.25;  // of the detection score and its weight
  PaperFitPoint start;
  start.detection_ms = std::clamp((kMaxMean - cell.posterior_mean.mean) * kMsPerReward, 0.3, 30.0);
  start.gap_ms = 3;
  if (cell.posterior_mean.mean < 0.5) start.rest_ms = start.gap_ms = 100;  // some 7 FPS
  if (SecondArm(cell)) start.second_gap_ms = 1;
  if (RanBelowTheStall(cell)) start.stall_ratio = 1 - 2 / SecondsPerUpdate(cell);
  return start;
}

double FourthPower(double x) { return x * x * x * x; }

using Parameter = double PaperFitPoint::*;

std::vector<Parameter> ParametersOf(const PaperFitPoint& start) {
  std::vector<Parameter> parameters = {&PaperFitPoint::gap_ms, &PaperFitPoint::detection_ms};
  if (start.second_gap_ms > 0) parameters.push_back(&PaperFitPoint::second_gap_ms);
  if (start.stall_ratio > 0) {
    parameters.push_back(&PaperFitPoint::stall_ratio);
    parameters.push_back(&PaperFitPoint::stall_period_s);
  }
  return parameters;
}

// The search for one cell.
class Search {
 public:
  Search(const PaperCell& cell, const PaperCheckOptions& options,
         const std::function<void()>& on_try)
      : cell_(cell), options_(options), on_try_(on_try), best_(StartOf(cell)), loss_(Loss(best_)) {}

  PaperFitPoint Run() {
    constexpr double kFirstFactor = 1.6;
    constexpr double kLastFactor = 1.03;
    constexpr double kGoodEnough = 0.05;  // every figure within half of what is allowed
    for (double factor = kFirstFactor; factor > kLastFactor && loss_ > kGoodEnough;) {
      if (!Round(factor)) factor = std::sqrt(factor);
    }
    return best_;
  }

 private:
  // Whether anything became better. Gap and detection also move together: either alone would upset
  // what the other has reached.
  bool Round(double factor) {
    bool any = false;
    for (const Parameter parameter : ParametersOf(best_)) {
      any |= Move(parameter, factor, parameter, 1) || Move(parameter, 1 / factor, parameter, 1);
    }
    constexpr Parameter kGap = &PaperFitPoint::gap_ms;
    constexpr Parameter kDetection = &PaperFitPoint::detection_ms;
    for (const double first : {factor, 1 / factor}) {
      any |= Move(kGap, first, kDetection, factor) || Move(kGap, first, kDetection, 1 / factor);
    }
    return any;
  }

  bool Move(Parameter first, double first_factor, Parameter second, double second_factor) {
    PaperFitPoint point = best_;
    point.*first *= first_factor;
    point.*second *= second_factor;
    point.stall_ratio = std::min(point.stall_ratio, 0.9);
    const double loss = Loss(point);
    if (loss >= loss_) return false;
    best_ = point;
    loss_ = loss;
    return true;
  }

  double Loss(const PaperFitPoint& point) const {
    const PaperCellFit fit = ExpandFit(cell_, point);
    const double loss = FitLoss(CheckPaper({&cell_, 1}, {&fit, 1}, options_, [](uint64_t) {})[0]);
    on_try_();
    return loss;
  }

  const PaperCell& cell_;
  const PaperCheckOptions options_;
  const std::function<void()>& on_try_;
  PaperFitPoint best_;
  double loss_;
};

}  // namespace

PaperCellFit ExpandFit(const PaperCell& cell, const PaperFitPoint& point) {
  const std::optional<std::string_view> second = SecondArm(cell);
  PaperCellFit fit{
      .arms = {}, .stall_ratio = point.stall_ratio, .stall_period_s = point.stall_period_s};
  for (size_t arm = 0; arm < kPaperArmCount; ++arm) {
    double gap_ms = kPaperArms[arm] == second ? point.second_gap_ms : point.gap_ms;
    if (kPaperArms[arm] == cell.dominant) gap_ms = 0;
    const double detection_ms = point.detection_ms + gap_ms;
    fit.arms[arm] = {point.rest_ms + detection_ms, detection_ms, kNoiseRatio};
  }
  return fit;
}

std::span<const PaperFitPoint> FittedPoints() { return kPoints; }

std::vector<PaperCellFit> PaperFits() {
  std::vector<PaperCellFit> fits;
  for (size_t cell = 0; cell < kPoints.size(); ++cell) {
    fits.push_back(ExpandFit(PaperCells()[cell], kPoints[cell]));
  }
  return fits;
}

double FitLoss(const PaperCheckRow& row) {
  constexpr double kDominanceTolerance = 2 * 0.22;  // deviations of x/5 at 0.6
  const double paper_ratio = static_cast<double>(row.cell.dominant_run_count) / kPaperRunCount;
  double loss = FourthPower((row.dominance_ratio - paper_ratio) / kDominanceTolerance);
  for (const PaperCheckFigure& figure : row.figures) {
    const double tolerance = (figure.allowed.high - figure.allowed.low) / 2;
    loss += FourthPower((figure.mean - figure.paper.mean) / tolerance);
  }
  return loss;
}

PaperFitPoint FindFit(const PaperCell& cell, const PaperCheckOptions& options,
                      const std::function<void()>& on_try) {
  return Search(cell, options, on_try).Run();
}

}  // namespace sweepstake::cli
