#include "engine_client/decider/policy/diagnosis.h"

#include <algorithm>
#include <cassert>
#include <cmath>  // std::sqrt, exactly rounded by IEEE 754
#include <vector>

#include "engine_client/math/beta_distribution.h"
#include "engine_client/math/difference_variances.h"
#include "engine_client/math/maximum.h"
#include "engine_client/math/portable_math.h"

namespace sweepstake::decision {
namespace {

// Returns how far above the mode, on the logit scale, the density of p becomes negligible. Newton's
// method solves for that point. It starts beyond the point and, because the function is concave,
// never passes it.
double NegligibleAbove(const BetaPosterior& p) {
  const double n = p.alpha + p.beta;
  const double mean = p.alpha / n;
  double offset =
      std::sqrt(-2 * kNegligibleLogDensity / p.alpha * n / p.beta) - kNegligibleLogDensity / p.beta;
  for (int i = 0; i < 100; ++i) {
    const double excess = LogitLogShape(p, offset) - kNegligibleLogDensity;
    if (excess > -4) break;
    const double y = (1 - mean) / (1 - mean + mean * math::Exp(offset));
    offset -= excess / (n * y - p.beta);
  }
  return offset;
}

// Rewards on the logit scale. All points are offsets t from one origin: the mode of the posterior
// whose support begins highest. The integrand needs the most digits near it.
class BetaRewards final : public IndependentVariables {
 public:
  explicit BetaRewards(std::span<const BetaPosterior> posteriors);

  size_t count() const override { return rewards_.size(); }
  double low(size_t i) const override { return rewards_[i].low; }
  double high(size_t i) const override { return rewards_[i].high; }
  double log_peak(size_t i) const override { return rewards_[i].log_peak; }
  void MoveTo(double t) override;
  ValueScale scale() const override;
  LogDensity At(size_t i) const override;

 private:
  struct Reward {
    BetaPosterior p;
    double low = 0;
    double high = 0;
    double log_peak = 0;
    double at_origin = 0;  // ln(density at the origin ÷ density at the peak)
  };

  std::vector<Reward> rewards_;
  bool mirrored_ = false;      // the mean of the posterior at the origin is above ½
  double origin_small_ = 0.5;  // min(mean, 1 − mean) of that posterior
  // State at the point of MoveTo: the offset t, the reward x, its complement y, and the growth of
  // ln(1 + e^t') from the origin to here, where t' is −t if mirrored_, else t.
  double t_ = 0;
  double x_ = 0.5;
  double y_ = 0.5;
  double log_ratio_ = 0;
};

BetaRewards::BetaRewards(std::span<const BetaPosterior> posteriors) {
  rewards_.reserve(posteriors.size());
  double highest_low = 0;
  double origin = 0;
  // Find the interval and the peak of each posterior, and the origin: the mode of the posterior
  // with the highest lower end.
  for (const BetaPosterior& posterior : posteriors) {
    const BetaPosterior p = Bounded(posterior);
    const double mode = LogitMode(p);
    const Reward reward = {.p = p,
                           .low = mode - NegligibleAbove(Mirrored(p)),
                           .high = mode + NegligibleAbove(p),
                           .log_peak = LogitLogPeak(p)};
    if (rewards_.empty() || reward.low > highest_low) {
      highest_low = reward.low;
      origin = mode;
      mirrored_ = p.alpha > p.beta;
      origin_small_ = std::min(p.alpha, p.beta) / (p.alpha + p.beta);
    }
    rewards_.push_back(reward);
  }
  // Make the intervals and densities relative to the origin.
  for (Reward& reward : rewards_) {
    reward.low -= origin;
    reward.high -= origin;
    reward.at_origin = LogitLogShape(reward.p, origin - LogitMode(reward.p));
  }
}

void BetaRewards::MoveTo(double t) {
  constexpr double kMaxExponent = 700;
  t_ = t;
  const double along = mirrored_ ? -t : t;
  double small = 1;
  double large = 0;
  if (along < kMaxExponent) {
    const double growth = origin_small_ * math::Expm1(along);
    log_ratio_ = math::Log1p(growth);
    small = (origin_small_ + growth) / (1 + growth);
    large = (1 - origin_small_) / (1 + growth);
  } else {
    log_ratio_ = along + math::Log(origin_small_);
  }
  x_ = mirrored_ ? large : small;
  y_ = mirrored_ ? small : large;
}

ValueScale BetaRewards::scale() const {
  return {
      .value = x_, .rate = x_ * y_, .log_rate_slope = y_ - x_, .log_rate_curvature = -2 * x_ * y_};
}

LogDensity BetaRewards::At(size_t i) const {
  const Reward& reward = rewards_[i];
  const double n = reward.p.alpha + reward.p.beta;
  const double along = mirrored_ ? -reward.p.beta * t_ : reward.p.alpha * t_;
  return {.relative = std::min(0.0, reward.at_origin + along - n * log_ratio_),
          .slope = mirrored_ ? n * y_ - reward.p.beta : reward.p.alpha - n * x_,
          .curvature = -n * x_ * y_};
}

// Independent normal log-costs, as offsets from the lowest mean. They are negated, because the base
// class looks for the highest value and the lowest cost is the best.
class NormalLogCosts final : public IndependentVariables {
 public:
  NormalLogCosts(std::span<const double> means, std::span<const double> variances);

  size_t count() const override { return costs_.size(); }
  double low(size_t i) const override { return costs_[i].mean - costs_[i].reach; }
  double high(size_t i) const override { return costs_[i].mean + costs_[i].reach; }
  double log_peak(size_t i) const override { return costs_[i].log_peak; }
  void MoveTo(double t) override { t_ = t; }
  ValueScale scale() const override { return {.value = t_}; }
  LogDensity At(size_t i) const override;

 private:
  struct Cost {
    double mean = 0;
    double precision = 1;
    double log_peak = 0;
    double reach = 0;
  };

  std::vector<Cost> costs_;
  double t_ = 0;
};

NormalLogCosts::NormalLogCosts(std::span<const double> means, std::span<const double> variances) {
  constexpr double kSmallestVariance = 1e-18;
  constexpr double kHalfLog2Pi = 0x1.d67f1c864beb5p-1;
  const double origin = *std::min_element(means.begin(), means.end());
  costs_.reserve(means.size());
  for (size_t i = 0; i < means.size(); ++i) {
    const double variance = std::max(variances[i], kSmallestVariance);
    costs_.push_back({.mean = origin - means[i],
                      .precision = 1 / variance,
                      .log_peak = -0.5 * math::Log(variance) - kHalfLog2Pi,
                      .reach = std::sqrt(-2 * kNegligibleLogDensity * variance)});
  }
}

LogDensity NormalLogCosts::At(size_t i) const {
  const Cost& cost = costs_[i];
  const double slope = (cost.mean - t_) * cost.precision;
  return {.relative = 0.5 * slope * (t_ - cost.mean), .slope = slope, .curvature = -cost.precision};
}

double Entropy(std::span<const double> probabilities) {
  double sum = 0;
  for (const double p : probabilities) {
    if (p > 0) sum -= p * math::Log(p);
  }
  return std::max(sum, 0.0);
}

// Returns the probabilities, the leader and the entropy. Expected loss, remaining value and verdict
// are not set.
Diagnosis FromProbabilities(std::vector<double> probabilities) {
  Diagnosis diagnosis;
  const auto highest = std::max_element(probabilities.begin(), probabilities.end());
  diagnosis.leader = static_cast<uint32_t>(highest - probabilities.begin());
  diagnosis.entropy = Entropy(probabilities);
  diagnosis.best_probability = std::move(probabilities);
  return diagnosis;
}

Diagnosis WithLoss(Diagnosis diagnosis, double expected_loss_ratio, double value_remaining_ratio) {
  diagnosis.expected_loss_ratio = std::max(expected_loss_ratio, 0.0);
  diagnosis.value_remaining_ratio = std::max(value_remaining_ratio, 0.0);
  diagnosis.verdict =
      VerdictOf(diagnosis.best_probability[diagnosis.leader], diagnosis.expected_loss_ratio);
  return diagnosis;
}

double HighestMean(std::span<const BetaPosterior> posteriors) {
  double highest = 0;
  for (const BetaPosterior& posterior : posteriors) highest = std::max(highest, posterior.mean());
  return highest;
}

bool NothingLearnt(std::span<const BetaPosterior> posteriors) {
  return std::all_of(posteriors.begin(), posteriors.end(),
                     [](const BetaPosterior& p) { return p == BetaPosterior{}; });
}

}  // namespace

Verdict VerdictOf(double leader_probability, double expected_loss_ratio) {
  if (leader_probability >= kStableProbability) return Verdict::kStable;
  return expected_loss_ratio <= kTieLossRatio ? Verdict::kTie : Verdict::kAmbiguous;
}

Diagnosis Diagnose(std::span<const BetaPosterior> posteriors) {
  if (NothingLearnt(posteriors)) return {};
  BetaRewards rewards(posteriors);
  Maximum maximum = IntegrateMaximum(rewards);
  Diagnosis diagnosis = FromProbabilities(std::move(maximum.probability));
  const double reward = posteriors[diagnosis.leader].mean();
  const double highest = HighestMean(posteriors);
  const double best = std::max(maximum.expected_value, highest);
  if (!(best > 0)) return WithLoss(std::move(diagnosis), 0, 0);
  return WithLoss(std::move(diagnosis), (best - reward) / best, (best - highest) / best);
}

Diagnosis DiagnoseLogCosts(std::span<const double> means, std::span<const double> variances) {
  assert(means.size() == variances.size());
  if (means.empty()) return {};
  NormalLogCosts costs(means, variances);
  Maximum maximum = IntegrateMaximum(costs);
  Diagnosis diagnosis = FromProbabilities(std::move(maximum.probability));
  const double lowest = *std::min_element(means.begin(), means.end());
  const double loss = maximum.expected_value + (means[diagnosis.leader] - lowest);
  return WithLoss(std::move(diagnosis), math::Expm1(loss), math::Expm1(maximum.expected_value));
}

Diagnosis DiagnoseCorrelatedLogCosts(std::span<const double> means,
                                     std::span<const double> covariance) {
  return DiagnoseLogCosts(means, IndependentVariancesLike(means, covariance));
}

}  // namespace sweepstake::decision
