#include "engine_client/decider/policy/regime_beliefs.h"

#include <utility>

#include "engine_client/math/portable_math.h"

namespace sweepstake::decision {
namespace {

constexpr double kNewVariance = 0.3 * 0.3;  // added to the beliefs of a new regime
constexpr double kMemoryIntervals = 12;     // time constant of shares and rates
constexpr double kMaxChangeRate = 0.4;

template <typename Weights>
double TotalOf(const Weights& weights) {
  double sum = 0;
  for (const double weight : weights) sum += weight;
  return sum;
}

}  // namespace

bool RegimeBeliefs::Observe(const SceneDescriptor& descriptor, double intervals) {
  const double kept = math::Exp(-intervals / kMemoryIntervals);
  for (double& share : shares_) share *= kept;
  shares_[regime_] += 1 - kept;
  const auto [regime, is_new] = memory_.Observe(descriptor);
  if (is_new && regime != regime_) {
    RelativeCostFilter beliefs = filter();
    beliefs.Widen(kNewVariance);
    if (regime == filters_.size()) filters_.push_back(beliefs);
    filters_[regime] = std::move(beliefs);
    shares_[regime] = 0;
  }
  const bool changed = regime != std::exchange(regime_, regime);
  change_rate_ = change_rate_ * kept + (changed ? 1 / kMemoryIntervals : 0);
  const bool mixed = std::exchange(mixes_, change_rate_ > kMaxChangeRate);
  return changed || mixed || mixes_;
}

RegimeBeliefs::Weights RegimeBeliefs::CostsOf(uint32_t arm) const {
  Weights costs{};
  for (uint32_t regime = 0; regime < filters_.size(); ++regime)
    costs[regime] = shares_[regime] * math::Exp(filters_[regime].LogCost(arm).mean);
  return costs;
}

NormalBelief RegimeBeliefs::LogCost(uint32_t arm) const {
  if (!mixes_) return filter().LogCost(arm);
  return {.mean = math::Log(TotalOf(CostsOf(arm)) / TotalOf(shares_)),
          .variance = Covariance(arm, arm)};
}

// In a mixture, an arm's log-cost is a weighted sum of its log-costs in the regimes; each weight is
// the regime's share in the arm's mean cost. Beliefs of different regimes count as independent.
double RegimeBeliefs::Covariance(uint32_t a, uint32_t b) const {
  if (!mixes_) return filter().Covariance(a, b);
  const Weights of_a = CostsOf(a);
  const Weights of_b = CostsOf(b);
  double covariance = 0;
  for (uint32_t regime = 0; regime < filters_.size(); ++regime)
    covariance += of_a[regime] * of_b[regime] * filters_[regime].Covariance(a, b);
  return covariance / (TotalOf(of_a) * TotalOf(of_b));
}

NormalBelief RegimeBeliefs::Difference(uint32_t a, uint32_t b) const {
  if (!mixes_) return filter().Difference(a, b);
  const double variance = Covariance(a, a) + Covariance(b, b) - 2 * Covariance(a, b);
  return {LogCost(a).mean - LogCost(b).mean, std::max(variance, 0.0)};
}

}  // namespace sweepstake::decision
