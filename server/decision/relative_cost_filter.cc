#include "server/decision/relative_cost_filter.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sweepstake::decision {
namespace {

constexpr double Square(double x) { return x * x; }

// Standard deviations of logarithms: 0.01 is 1 %.
constexpr double kLevelVariance = Square(2);      // of a common level of which nothing is known
constexpr double kUnknownVariance = Square(0.8);  // of an arm against the others
constexpr double kLaneVariance = Square(0.3);     // of the lane's core against the frame thread's
constexpr double kBiasVariance = Square(0.08);    // of an arm's own bias in the lane
constexpr double kSweepVariance = Square(0.05);
constexpr double kBiasDrift = Square(0.001);  // per interval, as are the next ones
constexpr double kFirstDrift = Square(0.005);
constexpr double kFirstLevelDrift = Square(0.03);
constexpr double kLeastDrift = Square(0.001);
constexpr double kMostDrift = Square(0.1);
constexpr double kFirstNoise = Square(0.05);
constexpr double kLeastNoise = Square(0.005);
constexpr double kMostNoise = Square(0.5);

constexpr double kSurprise = 3;
constexpr double kNoiseRate = 0.05;
constexpr double kDriftRate = 0.1;

// NaN is the most.
double Clamped(double log_cost) {
  return log_cost <= kMostLogCost ? std::max(log_cost, kLeastLogCost) : kMostLogCost;
}

// Follows the noise that explains innovations of this size, as far as they are noise at all: where
// the belief itself is wide they tell nothing of it.
void FollowNoise(double& noise, double innovation, double variance) {
  const double share = noise / variance;
  const double excess = std::min(Square(innovation) / variance, Square(kSurprise)) - 1;
  noise = std::clamp(noise * (1 + kNoiseRate * share * excess), kLeastNoise, kMostNoise);
}

// `product`: of two successive normalised innovations. Where they agree, the belief lags behind.
void FollowDrift(double& drift, double product) {
  drift = std::clamp(drift * (1 + kDriftRate * std::clamp(product, -4.0, 4.0)), kLeastDrift,
                     kMostDrift);
}

}  // namespace

RelativeCostFilter::RelativeCostFilter(uint32_t arm_count)
    : arm_count_(arm_count),
      mean_(Eigen::VectorXd::Zero(2 * arm_count + 1)),
      covariance_(Eigen::MatrixXd::Zero(2 * arm_count + 1, 2 * arm_count + 1)),
      last_innovation_(arm_count),
      live_noise_(kFirstNoise),
      shadow_noise_(kFirstNoise),
      drift_(kFirstDrift),
      level_drift_(kFirstLevelDrift) {
  mean_.head(arm_count).setConstant(7.6);  // 2 ms
  AddCommonVariance(kLevelVariance);
  covariance_.diagonal().head(arm_count).array() += kUnknownVariance;
  covariance_.block(arm_count, arm_count, arm_count, arm_count).array() += kLaneVariance;
  covariance_.diagonal().segment(arm_count, arm_count).array() += kBiasVariance;
}

void RelativeCostFilter::SetPrior(uint32_t arm, const NormalBelief& log_cost) {
  mean_[arm] = Clamped(log_cost.mean);
  covariance_(arm, arm) = kLevelVariance + log_cost.variance;
}

void RelativeCostFilter::Advance(double intervals) {
  AddCommonVariance(level_drift_ * intervals);
  covariance_.diagonal().head(arm_count_).array() += drift_ * intervals;
  covariance_.diagonal().segment(arm_count_, arm_count_).array() += kBiasDrift * intervals;
}

void RelativeCostFilter::AddCommonVariance(double variance) {
  covariance_.topLeftCorner(arm_count_, arm_count_).array() += variance;
}

Eigen::VectorXd RelativeCostFilter::Sensitivity(uint32_t arm, bool shadow) const {
  Eigen::VectorXd column = covariance_.col(arm);
  if (shadow) column += covariance_.col(arm_count_ + arm) + covariance_.col(2 * arm_count_);
  return column;
}

double RelativeCostFilter::Predicted(uint32_t arm, bool shadow) const {
  return mean_[arm] + (shadow ? mean_[arm_count_ + arm] + mean_[2 * arm_count_] : 0);
}

void RelativeCostFilter::Update(const Eigen::VectorXd& sensitivity, double innovation,
                                double innovation_variance) {
  mean_ += sensitivity * (innovation / innovation_variance);
  covariance_.noalias() -= sensitivity * (sensitivity / innovation_variance).transpose();
  mean_.head(arm_count_) = mean_.head(arm_count_).cwiseMax(kLeastLogCost).cwiseMin(kMostLogCost);
  covariance_.diagonal() = covariance_.diagonal().cwiseMax(1e-12);
}

void RelativeCostFilter::ObserveLive(uint32_t arm, double log_cost) {
  const double innovation = Clamped(log_cost) - mean_[arm];
  const bool stays = std::exchange(live_arm_, arm) == arm;
  double variance = covariance_(arm, arm) + live_noise_;
  const double normalised = innovation / std::sqrt(variance);
  const double last = std::exchange(last_live_innovation_, normalised);
  if (stays) FollowDrift(level_drift_, normalised * last);
  if (std::abs(normalised) > kSurprise) {
    // What changes while an arm stays may change all of them; what another arm shows is its own.
    if (stays) AddCommonVariance(Square(innovation));
    if (!stays) covariance_(arm, arm) += Square(innovation);
    variance = covariance_(arm, arm) + live_noise_;
  }
  FollowNoise(live_noise_, innovation, variance);
  Update(Sensitivity(arm, false), innovation, variance);
}

void RelativeCostFilter::BeginSweep(uint64_t sweep) {
  if (sweep_ == sweep) return;
  sweep_ = sweep;
  sweep_has_reference_ = false;
  const uint32_t offset = 2 * arm_count_;
  mean_[offset] = 0;
  covariance_.row(offset).setZero();
  covariance_.col(offset).setZero();
  covariance_(offset, offset) = kSweepVariance;
}

void RelativeCostFilter::ObserveShadow(uint32_t arm, uint64_t sweep, double log_cost) {
  BeginSweep(sweep);
  const double innovation = Clamped(log_cost) - Predicted(arm, true);
  Eigen::VectorXd sensitivity = Sensitivity(arm, true);
  const auto believed = [&] {
    return sensitivity[arm] + sensitivity[arm_count_ + arm] + sensitivity[2 * arm_count_];
  };
  double noise = shadow_noise_;
  double variance = believed() + noise;
  const bool surprising = Square(innovation) > Square(kSurprise) * variance;
  if (!sweep_has_reference_) {
    // Whatever the sweep's first visit shows, all arms may share.
    if (surprising) AddCommonVariance(Square(innovation));
  } else {
    const double normalised = innovation / std::sqrt(variance);
    const std::optional<double> last = std::exchange(last_innovation_[arm], normalised);
    if (last) FollowDrift(drift_, normalised * *last);
    if (surprising && (!last || (std::abs(*last) > kSurprise && normalised * *last > 0))) {
      covariance_(arm, arm) += Square(innovation);
      last_innovation_[arm] = 0;
    } else {
      FollowNoise(shadow_noise_, innovation, variance);
      if (surprising) noise = Square(innovation);
    }
  }
  sweep_has_reference_ = true;
  sensitivity = Sensitivity(arm, true);
  Update(sensitivity, innovation, believed() + noise);
}

void RelativeCostFilter::Assume(uint32_t arm, double log_cost) {
  mean_[arm] = Clamped(log_cost);
  covariance_.row(arm).setZero();
  covariance_.col(arm).setZero();
  covariance_(arm, arm) = Square(0.5);
}

NormalBelief RelativeCostFilter::LogCost(uint32_t arm) const {
  return {mean_[arm], covariance_(arm, arm)};
}

NormalBelief RelativeCostFilter::Difference(uint32_t a, uint32_t b) const {
  const double variance = covariance_(a, a) + covariance_(b, b) - 2 * covariance_(a, b);
  return {mean_[a] - mean_[b], std::max(variance, 0.0)};
}

}  // namespace sweepstake::decision
