#include "server/decision/policy/relative_cost_filter.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sweepstake::decision {
namespace {

constexpr double Square(double x) { return x * x; }

// Squares of standard deviations of logarithms: 0.01 is 1 %. Chosen on the traces of
// tests/bench/tuning_scenes.txt; half or twice any of them changes little.
constexpr double kFirstLevel = 7.6;               // 2 ms
constexpr double kLevelVariance = Square(2);      // of a common level of which nothing is known
constexpr double kUnknownVariance = Square(0.8);  // of an arm against the others
constexpr double kLaneVariance = Square(0.3);     // of the lane against the frame thread
constexpr double kBiasVariance = Square(0.04);    // of what the lane gets wrong of an arm
constexpr double kAssumedVariance = Square(0.5);
// Noises.
constexpr double kFirstNoise = Square(0.05);
constexpr double kLeastNoise = Square(0.005);
constexpr double kMostNoise = Square(0.5);
// Drifts per interval.
constexpr double kBiasDrift = Square(0.003);
constexpr double kFirstDrift = Square(0.005);
constexpr double kFirstLevelDrift = Square(0.03);
constexpr double kFirstLaneDrift = Square(0.01);
constexpr double kLeastDrift = Square(0.001);
constexpr double kMostDrift = Square(0.1);

constexpr double kSurprise = 3;  // standard deviations
constexpr double kNoiseRate = 0.05;
constexpr double kDriftRate = 0.1;
constexpr double kMostProduct = 4;
// Of a surprise in a live window of an arm that stays: that it is this arm's alone.
constexpr double kOwnShare = 0.3;

double Clamped(double log_cost) {
  return log_cost <= kMostLogCost ? std::max(log_cost, kLeastLogCost) : kMostLogCost;
}

bool Agree(double a, double b) { return std::min(a, b) > kSurprise || std::max(a, b) < -kSurprise; }

}  // namespace

RelativeCostFilter::RelativeCostFilter(uint32_t arm_count, const FilterLevers& levers)
    : arm_count_(arm_count),
      levers_(levers),
      mean_(Eigen::VectorXd::Zero(2 * arm_count + 1)),
      covariance_(Eigen::MatrixXd::Zero(2 * arm_count + 1, 2 * arm_count + 1)),
      live_noise_(kFirstNoise),
      shadow_noise_(kFirstNoise),
      sweep_noise_(kFirstNoise),
      drift_(kFirstDrift),
      level_drift_(kFirstLevelDrift),
      lane_drift_(kFirstLaneDrift),
      last_visit_(arm_count) {
  mean_.head(arm_count).setConstant(kFirstLevel);
  AddCommonVariance(0, kLevelVariance);
  AddCommonVariance(bias(0), kLaneVariance);
  covariance_.diagonal().head(arm_count).array() += kUnknownVariance;
  covariance_.diagonal().segment(bias(0), arm_count).array() += kBiasVariance;
}

void RelativeCostFilter::SetPrior(uint32_t arm, const NormalBelief& log_cost) {
  mean_[arm] = Clamped(log_cost.mean);
  covariance_(arm, arm) = kLevelVariance + log_cost.variance;
}

void RelativeCostFilter::Advance(double intervals) {
  AddCommonVariance(0, level_drift_ * intervals);
  AddCommonVariance(bias(0), lane_drift_ * intervals);
  covariance_.diagonal().head(arm_count_).array() += drift_ * intervals;
  covariance_.diagonal().segment(bias(0), arm_count_).array() += kBiasDrift * intervals;
}

// All arms' states from this one on move together.
void RelativeCostFilter::AddCommonVariance(uint32_t first_state, double variance) {
  auto block = covariance_.block(first_state, first_state, arm_count_, arm_count_);
  if (levers_.common_mode) {
    block.array() += variance;
  } else {
    block.diagonal().array() += variance;
  }
}

// The noise that explains innovations of this size, as far as they are noise at all: where the
// belief itself is wide they tell nothing of it.
void RelativeCostFilter::FollowNoise(double& noise, double innovation, double variance) const {
  if (!levers_.calibration) return;
  const double excess = std::min(Square(innovation) / variance, Square(kSurprise)) - 1;
  noise *= 1 + kNoiseRate * noise / variance * excess;
  noise = std::clamp(noise, kLeastNoise, kMostNoise);
}

// `product`: of two successive normalised innovations. Where they agree, the belief lags behind.
void RelativeCostFilter::FollowDrift(double& drift, double product) const {
  if (!levers_.calibration) return;
  drift *= 1 + kDriftRate * std::clamp(product, -kMostProduct, kMostProduct);
  drift = std::clamp(drift, kLeastDrift, kMostDrift);
}

void RelativeCostFilter::ObserveLive(uint32_t arm, double log_cost) {
  const double innovation = Clamped(log_cost) - mean_[arm];
  const bool stays = std::exchange(live_arm_, arm) == arm;
  const double variance = covariance_(arm, arm) + live_noise_;
  const double normalised = innovation / std::sqrt(variance);
  const double last = std::exchange(last_live_, normalised);
  if (stays) FollowDrift(level_drift_, normalised * last);
  double noise = live_noise_;
  if (std::abs(normalised) > kSurprise) {
    // What changes while an arm stays may change all of them; what another arm shows is its own.
    if (!stays) {
      covariance_(arm, arm) += Square(innovation);
    } else if (Agree(last, normalised)) {
      AddCommonVariance(0, Square(innovation));
      covariance_(arm, arm) += kOwnShare * Square(innovation);
      last_live_ = 0;
    } else {
      noise = Square(innovation);
    }
  }
  FollowNoise(live_noise_, innovation, variance);
  Update(covariance_.col(arm), innovation, covariance_(arm, arm) + noise);
}

void RelativeCostFilter::BeginSweep(uint64_t sweep) {
  if (sweep_ == sweep) return;
  sweep_ = sweep;
  reference_visited_ = false;
  mean_[offset()] = 0;
  covariance_.row(offset()).setZero();
  covariance_.col(offset()).setZero();
  covariance_(offset(), offset()) = sweep_noise_;
}

// Of x_i + b_i + c, whose covariances with everything `column` holds.
double RelativeCostFilter::VisitVariance(const Eigen::VectorXd& column, uint32_t arm) const {
  return column[arm] + column[bias(arm)] + column[offset()];
}

void RelativeCostFilter::ObserveShadow(uint32_t arm, uint64_t sweep, double log_cost) {
  BeginSweep(sweep);
  const auto column = [&]() -> Eigen::VectorXd {
    return covariance_.col(arm) + covariance_.col(bias(arm)) + covariance_.col(offset());
  };
  const double innovation = Clamped(log_cost) - mean_[arm] - mean_[bias(arm)] - mean_[offset()];
  const double variance = VisitVariance(column(), arm) + shadow_noise_;
  const bool is_reference = !std::exchange(reference_visited_, true);
  const double noise = is_reference ? TakeReferenceVisit(innovation, variance)
                                    : TakeVisit(arm, innovation, variance);
  const Eigen::VectorXd widened = column();
  Update(widened, innovation, VisitVariance(widened, arm) + noise);
}

// Whatever a sweep's first visit shows, all arms may share. Returns the noise to take it with, as
// does TakeVisit.
double RelativeCostFilter::TakeReferenceVisit(double innovation, double variance) {
  const double normalised = innovation / std::sqrt(variance);
  const double last = std::exchange(last_reference_, normalised);
  FollowDrift(lane_drift_, normalised * last);
  if (std::abs(normalised) > kSurprise) {
    AddCommonVariance(0, Square(innovation));
  } else {
    FollowNoise(sweep_noise_, innovation, variance);
  }
  return shadow_noise_;
}

double RelativeCostFilter::TakeVisit(uint32_t arm, double innovation, double variance) {
  const double normalised = innovation / std::sqrt(variance);
  const bool surprises = std::abs(normalised) > kSurprise;
  const std::optional<double> last = std::exchange(last_visit_[arm], normalised);
  if (last) FollowDrift(drift_, normalised * *last);
  if (surprises && (!last || Agree(*last, normalised))) {
    last_visit_[arm] = 0;
    covariance_(arm, arm) += Square(innovation);
    return shadow_noise_;
  }
  const double noise = surprises ? Square(innovation) : shadow_noise_;
  FollowNoise(shadow_noise_, innovation, variance);
  return noise;
}

// `column`: covariances of what was observed with every state.
void RelativeCostFilter::Update(const Eigen::VectorXd& column, double innovation, double variance) {
  const Eigen::VectorXd gain = column / variance;
  mean_ += gain * innovation;
  covariance_.noalias() -= column * gain.transpose();
  mean_.head(arm_count_) = mean_.head(arm_count_).cwiseMax(kLeastLogCost).cwiseMin(kMostLogCost);
  covariance_.diagonal() = covariance_.diagonal().cwiseMax(0);
}

void RelativeCostFilter::Assume(uint32_t arm, double log_cost) {
  mean_[arm] = Clamped(log_cost);
  covariance_.row(arm).setZero();
  covariance_.col(arm).setZero();
  covariance_(arm, arm) = kAssumedVariance;
}

NormalBelief RelativeCostFilter::Difference(uint32_t a, uint32_t b) const {
  const double variance = covariance_(a, a) + covariance_(b, b) - 2 * covariance_(a, b);
  return {mean_[a] - mean_[b], std::max(variance, 0.0)};
}

}  // namespace sweepstake::decision
