#include "engine_client/math/maximum.h"

#include <algorithm>
#include <cassert>
#include <cmath>  // std::sqrt, exactly rounded by IEEE 754

#include "engine_client/math/portable_math.h"

namespace sweepstake::decision {
namespace {

// The length of an integration step, as a multiple of the scale on which the densities change. Half
// of this length would make the error 60 times smaller.
constexpr double kStep = 0.5;
// The scale at a point is derived from the slope and the curvature of the densities (Demand). This
// is the weight of the slope; the curvature's weight is 1. With this value, the steps in an
// exponential tail are 0.7 of its scale, which is short enough.
constexpr double kSlopeWeight = 0.5;
// Lower probabilities are treated as 0, since they change no result.
constexpr double kNegligibleProbability = 1e-12;

// The value of a function and its first two derivatives at a point.
struct Jet {
  double value = 0;
  double first = 0;
  double second = 0;
};

// Returns the Jet of a function, given its value and the first two derivatives of its logarithm.
Jet FromLogarithm(double value, double slope, double curvature) {
  return {value, value * slope, value * (slope * slope + curvature)};
}

// Returns the integral between two points by Hermite's rule, which is exact for polynomials of
// degree 5.
double Between(const Jet& left, const Jet& right, double width) {
  return width * ((left.value + right.value) / 2 + width * (left.first - right.first) / 10 +
                  width * width * (left.second + right.second) / 120);
}

// Integrates over t, from the highest end of all variables downwards.
class MaximumIntegral {
 public:
  explicit MaximumIntegral(IndependentVariables& variables);
  Maximum Run();

 private:
  struct Variable {
    size_t index = 0;
    double high = 0;
    double log_peak = 0;
    LogDensity log_density;
    Jet density;
    double ratio = 0;        // density ÷ P(the variable is below t)
    double ratio_slope = 0;  // its derivative
    Jet win;                 // the density of being the maximum
    double above = 0;        // P(the variable is above t)
    double probability = 0;  // P(the variable is the maximum, above t)
  };

  double Demand() const;
  void EvaluateLogDensities();
  bool Join();
  double NextPoint() const;
  void StepTo(double t);
  void UpdateWins(double width);
  void UpdateShortfall(double width, double win_ratio, double win_ratio_slope);

  IndependentVariables& source_;
  std::vector<Variable> variables_;  // sorted, the highest end first
  size_t joined_ = 0;                // the number of variables whose high end is at t or above
  double t_;
  double end_;              // the highest low end: some variable is certainly above it
  double all_below_ = 1;    // P(all are below t)
  Jet shortfall_;           // P(some variable is above t) · dv/dt
  double value_above_ = 0;  // integral of shortfall_ from t upwards
};

MaximumIntegral::MaximumIntegral(IndependentVariables& variables) : source_(variables) {
  variables_.resize(source_.count());
  for (size_t i = 0; i < variables_.size(); ++i) {
    variables_[i].index = i;
    variables_[i].high = source_.high(i);
    variables_[i].log_peak = source_.log_peak(i);
  }
  std::stable_sort(variables_.begin(), variables_.end(),
                   [](const Variable& a, const Variable& b) { return a.high > b.high; });
  t_ = variables_.front().high;
  end_ = source_.low(0);
  for (size_t i = 1; i < variables_.size(); ++i) end_ = std::max(end_, source_.low(i));
  source_.MoveTo(t_);
  Join();
  UpdateWins(0);
}

// Adds the variables whose high end is at the current point, and returns whether there are any.
// Must be called after the interval above the point has been integrated: that interval is too wide
// for the densities of these variables.
bool MaximumIntegral::Join() {
  const size_t before = joined_;
  while (joined_ < variables_.size() && variables_[joined_].high >= t_) ++joined_;
  if (joined_ > before) EvaluateLogDensities();
  return joined_ > before;
}

void MaximumIntegral::EvaluateLogDensities() {
  for (size_t i = 0; i < joined_; ++i) variables_[i].log_density = source_.At(variables_[i].index);
}

// Returns 1 ÷ the square of the scale on which the integrands change at the current point. The
// lower the density, the lower the weight of its slope.
double MaximumIntegral::Demand() const {
  double max = -source_.scale().log_rate_curvature / 8;
  for (size_t i = 0; i < joined_; ++i) {
    const LogDensity& at = variables_[i].log_density;
    const double own = kSlopeWeight * at.slope * at.slope / (1 - at.relative) - at.curvature;
    max = std::max(max, own);
  }
  return max;
}

double MaximumIntegral::NextPoint() const {
  double next = std::max(t_ - kStep / std::sqrt(Demand()), end_);
  if (joined_ < variables_.size()) next = std::max(next, variables_[joined_].high);
  return next;
}

// Steps to `t`, or to a nearer point if the integrands change too much on the way.
void MaximumIntegral::StepTo(double t) {
  for (;;) {
    source_.MoveTo(t);
    EvaluateLogDensities();
    const double width = t_ - t;
    if (width * width * Demand() <= 4 * kStep * kStep) break;
    const double nearer = (t + t_) / 2;
    if (!(t < nearer && nearer < t_)) break;  // no number lies between them
    t = nearer;
  }
  const double width = t_ - t;
  t_ = t;
  UpdateWins(width);
  if (Join()) UpdateWins(0);
}

void MaximumIntegral::UpdateWins(double width) {
  double all_below = 1;
  double win_ratio = 0;        // density of the maximum ÷ P(all are below)
  double win_ratio_slope = 0;  // its derivative
  for (size_t i = 0; i < joined_; ++i) {
    Variable& v = variables_[i];
    const Jet density = FromLogarithm(math::Exp(v.log_peak + v.log_density.relative),
                                      v.log_density.slope, v.log_density.curvature);
    v.above += Between(density, v.density, width);
    v.density = density;
    const double below = std::max(1 - v.above, kNegligibleProbability);
    all_below *= below;
    v.ratio = density.value / below;
    v.ratio_slope = v.ratio * (v.log_density.slope - v.ratio);
    win_ratio += v.ratio;
    win_ratio_slope += v.ratio_slope;
  }
  for (size_t i = 0; i < joined_; ++i) {
    Variable& v = variables_[i];
    const Jet win = FromLogarithm(all_below * v.ratio, win_ratio + v.log_density.slope - v.ratio,
                                  win_ratio_slope + v.log_density.curvature - v.ratio_slope);
    v.probability += Between(win, v.win, width);
    v.win = win;
  }
  all_below_ = all_below;
  UpdateShortfall(width, win_ratio, win_ratio_slope);
}

void MaximumIntegral::UpdateShortfall(double width, double win_ratio, double win_ratio_slope) {
  const ValueScale scale = source_.scale();
  const Jet rate = FromLogarithm(scale.rate, scale.log_rate_slope, scale.log_rate_curvature);
  const Jet below = FromLogarithm(all_below_, win_ratio, win_ratio_slope);
  const double above = 1 - below.value;
  const Jet shortfall = {
      above * rate.value, above * rate.first - below.first * rate.value,
      above * rate.second - 2 * below.first * rate.first - below.second * rate.value};
  value_above_ += Between(shortfall, shortfall_, width);
  shortfall_ = shortfall;
}

Maximum MaximumIntegral::Run() {
  while (t_ > end_ && all_below_ > kNegligibleProbability) {
    const double next = NextPoint();
    if (!(next < t_)) break;  // the density is narrower than the resolution of t
    StepTo(next);
  }
  Maximum result;
  result.probability.resize(variables_.size());
  double sum = 0;
  for (const Variable& v : variables_) sum += std::max(v.probability, 0.0);
  for (const Variable& v : variables_)
    result.probability[v.index] = sum > 0 ? std::max(v.probability, 0.0) / sum : 0;
  result.expected_value = source_.scale().value + value_above_;
  return result;
}

}  // namespace

Maximum IntegrateMaximum(IndependentVariables& variables) {
  assert(variables.count() > 0);
  return MaximumIntegral(variables).Run();
}

}  // namespace sweepstake::decision
