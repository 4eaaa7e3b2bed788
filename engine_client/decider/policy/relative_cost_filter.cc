#include "engine_client/decider/policy/relative_cost_filter.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine_client/math/normal_distribution.h"

namespace sweepstake::decision {
namespace {

constexpr double Square(double x) { return x * x; }

// Each variance is written as the square of a standard deviation of a log-cost: Square(0.01) stands
// for 1 %. The values were chosen on the traces of tests/bench/data/tuning_scenes.txt. Halving or
// doubling any one value changes the results on these traces little. A drift is the growth of a
// variance per decision interval.
constexpr double kFirstLevel = 7.6;           // mean log-cost before any observation: 2 ms
constexpr double kLevelVariance = Square(2);  // of the level that all arms share
constexpr double kFirstNoise = Square(0.2);   // of a window, a visit and a sweep
constexpr double kFirstDrift = Square(0.005);
// Limits of all noises and drifts. The minimum is also the drift of an arm's lane bias.
constexpr double kMinVariance = Square(0.001);
constexpr double kMaxVariance = Square(0.5);

constexpr double kNoiseFreedom = 6;  // of Student's t distribution; 4 to 10 differ little
constexpr double kRate = 0.05;       // step size of the estimates of noises and drifts

double Clamped(double log_cost) {
  return log_cost <= kMaxLogCost ? std::max(log_cost, kMinLogCost) : kMaxLogCost;
}

}  // namespace

RelativeCostFilter::RelativeCostFilter(uint32_t arm_count, const FilterComponents& components)
    : arm_count_(arm_count),
      components_(components),
      mean_(Eigen::VectorXd::Zero(arm_count + 1)),
      covariance_(Eigen::MatrixXd::Zero(arm_count + 1, arm_count + 1)),
      live_noise_(kFirstNoise),
      shadow_noise_(kFirstNoise),
      sweep_noise_(kFirstNoise),
      drift_(kFirstDrift),
      level_drift_(kFirstDrift),
      lane_drift_(kFirstDrift),
      last_visit_(arm_count) {
  ForgetCosts();
  AddVariance(first_biases_, kUnknownVariance, kLaneBiasVariance);
}

void RelativeCostFilter::ForgetCosts() {
  mean_.head(arm_count_).setConstant(kFirstLevel);
  covariance_.topRows(arm_count_).setZero();
  covariance_.leftCols(arm_count_).setZero();
  AddVariance(costs(), kLevelVariance, kUnknownVariance);
}

// Adds the states of the lane to the filter: the bias of each arm, and the offset of the sweep.
void RelativeCostFilter::AddLane() {
  const uint32_t state_count = offset() + 1;
  mean_.conservativeResizeLike(Eigen::VectorXd::Zero(state_count));
  covariance_.conservativeResizeLike(Eigen::MatrixXd::Zero(state_count, state_count));
  biases().setConstant(first_biases_(0, 1));
  biases().diagonal().setConstant(first_biases_(0, 0));
}

void RelativeCostFilter::SetPrior(uint32_t arm, const NormalBelief& log_cost) {
  mean_[arm] = Clamped(log_cost.mean);
  covariance_(arm, arm) = kLevelVariance + log_cost.variance;
}

// A load may end at any time, so its variance grows by its squared mean per interval.
void RelativeCostFilter::Advance(double intervals) {
  AddVariance(costs(), level_drift_ * intervals, drift_ * intervals);
  covariance_(load(), load()) += Square(mean_[load()]) * intervals;
  const double lane = lane_drift_ * intervals, own = kMinVariance * intervals;
  has_lane() ? AddVariance(biases(), lane, own) : AddVariance(first_biases_, lane, own);
}

// Returns the weight of an observation with this normalised innovation, if noise has Student's t
// distribution: less than 1 if the innovation is large (K. Lange, R. Little, J. Taylor, "Robust
// statistical modeling using the t distribution", JASA 84, 1989).
double RelativeCostFilter::WeightOf(double normalised) const {
  if (!components_.heavy_tails) return 1;
  return (kNoiseFreedom + 1) / (kNoiseFreedom + Square(normalised));
}

// Returns whether a normalised innovation has less than half of an observation's weight.
bool RelativeCostFilter::IsOutlier(double normalised) const { return WeightOf(normalised) < 0.5; }

// Returns whether two successive normalised innovations show a change: both are outliers, on the
// same side. An outlier without a predecessor is a change, too.
bool RelativeCostFilter::IsChange(const std::optional<double>& last, double normalised) const {
  const double before = last.value_or(normalised);
  return IsOutlier(before) && IsOutlier(normalised) && (before > 0) == (normalised > 0);
}

double RelativeCostFilter::VarianceOf(double noise) const {
  return components_.heavy_tails ? noise * kNoiseFreedom / (kNoiseFreedom - 2) : noise;
}

void RelativeCostFilter::Widen(double variance) { AddVariance(costs(), variance, variance); }

void RelativeCostFilter::AddVariance(Eigen::Ref<Eigen::MatrixXd> states, double common,
                                     double own) const {
  if (components_.common_mode) {
    states.array() += common;
  } else {
    states.diagonal().array() += common;
  }
  states.diagonal().array() += own;
}

// Moves a noise variance towards the value that would explain innovations of this size. The step is
// small if the belief itself is wide, because innovations then show little about the noise.
void RelativeCostFilter::UpdateNoise(double& noise, double normalised, double variance) const {
  if (!components_.calibration) return;
  const double excess = WeightOf(normalised) * Square(normalised) - 1;
  noise *= 1 + kRate * noise / variance * excess;
  noise = std::clamp(noise, kMinVariance, kMaxVariance);
}

// Changes a drift variance by the product of two successive normalised innovations. If both have
// the same sign, the belief lags behind the costs, so the drift is increased.
void RelativeCostFilter::UpdateDrift(double& drift, const std::optional<double>& last,
                                     double normalised) const {
  if (!components_.calibration || !last) return;
  const double weight = std::sqrt(WeightOf(*last) * WeightOf(normalised));
  drift *= 1 + kRate * weight * *last * normalised;
  drift = std::clamp(drift, kMinVariance, kMaxVariance);
}

void RelativeCostFilter::ObserveLive(uint32_t arm, double log_cost, bool lane_would_show) {
  const auto variance_in = [&](const Eigen::VectorXd& of) { return of[arm] + of[load()]; };
  const double innovation = Clamped(log_cost) - mean_[arm] - mean_[load()];
  const double variance = variance_in(LiveColumn(arm)) + live_noise_;
  const double normalised = innovation / std::sqrt(variance);
  const std::optional<double> last = std::exchange(last_live_, normalised);
  UpdateDrift(level_drift_, last, normalised);
  double noise = live_noise_ / WeightOf(normalised);
  // The cause of a change is other work on the core, which the lane does not see, a change of the
  // scene, which affects all arms, or a change of this arm alone. Widen all three. The first window
  // is the first to show the level of the costs, so it shows no load.
  if (IsChange(last, normalised)) {
    last_live_ = 0;
    noise = live_noise_;
    AddVariance(costs(), Square(innovation), 0);
    if (has_lane() && last) covariance_(load(), load()) += Square(innovation);
    if (!lane_would_show) covariance_(arm, arm) += Square(innovation);
  } else {
    UpdateNoise(live_noise_, normalised, variance);
  }
  const Eigen::VectorXd widened = LiveColumn(arm);
  Update(widened, innovation, variance_in(widened) + noise);
  KeepLoadPositive();
}

// Applies a lower bound of the arm's live cost. If the mean is above the bound, the belief loses
// its part below the bound. If it is below, the bound counts as a window of that cost. The noise of
// windows is not updated, because a trial is not a window.
void RelativeCostFilter::ObserveBound(uint32_t arm, double log_cost) {
  const double innovation = Clamped(log_cost) - mean_[arm] - mean_[load()];
  if (innovation <= 0) {
    const Eigen::VectorXd column = LiveColumn(arm);
    Truncate(column, innovation, column[arm] + column[load()]);
    return KeepLoadPositive();
  }
  const Eigen::VectorXd column = LiveColumn(arm);
  const double variance = column[arm] + column[load()];
  const double weight = WeightOf(innovation / std::sqrt(variance + live_noise_));
  Update(column, innovation, variance + live_noise_ / weight);
  KeepLoadPositive();
}

// Truncates the normal belief about a quantity below a bound, and replaces it by the normal
// distribution with the resulting mean and variance. The bound lies at `innovation` from the mean.
void RelativeCostFilter::Truncate(const Eigen::VectorXd& column, double innovation,
                                  double variance) {
  if (variance <= 0) return;
  const double deviation = std::sqrt(variance);
  const double z = innovation / deviation;
  const double shift = NormalDensity(z) / NormalCdf(-z);  // by how many deviations the mean moves
  const double share = shift * (shift - z);               // relative decrease of the variance
  if (share > 0) Update(column, deviation / (shift - z), variance / share);
}

// Returns the covariances of x_i + l, which a live window of the arm measures, with every state.
Eigen::VectorXd RelativeCostFilter::LiveColumn(uint32_t arm) const {
  return covariance_.col(arm) + covariance_.col(load());
}

// If the mean of the load has fallen below 0, sets it to 0 by an observation of that value.
void RelativeCostFilter::KeepLoadPositive() {
  if (mean_[load()] >= 0) return;
  const Eigen::VectorXd column = covariance_.col(load());
  Update(column, -mean_[load()], column[load()] + kMinVariance);
  mean_[load()] = 0;
}

void RelativeCostFilter::BeginSweep(uint64_t sweep) {
  if (sweep_ == sweep) return;
  sweep_ = sweep;
  has_visit_ = false;
  mean_[offset()] = 0;
  covariance_.row(offset()).setZero();
  covariance_.col(offset()).setZero();
  covariance_(offset(), offset()) = sweep_noise_;
}

// Returns the covariances of x_i + b_i + c, which a visit of the arm measures, with every state.
Eigen::VectorXd RelativeCostFilter::VisitColumn(uint32_t arm) const {
  return covariance_.col(arm) + covariance_.col(bias(arm)) + covariance_.col(offset());
}

double RelativeCostFilter::VisitInnovation(uint32_t arm, double log_cost) const {
  return Clamped(log_cost) - mean_[arm] - mean_[bias(arm)] - mean_[offset()];
}

// Returns the variance of x_i + b_i + c; `column` is VisitColumn(arm).
double RelativeCostFilter::VisitVariance(const Eigen::VectorXd& column, uint32_t arm) const {
  return column[arm] + column[bias(arm)] + column[offset()];
}

void RelativeCostFilter::ObserveShadow(uint32_t arm, uint64_t sweep, double log_cost) {
  if (!has_lane()) AddLane();
  BeginSweep(sweep);
  const double innovation = VisitInnovation(arm, log_cost);
  const double variance = VisitVariance(VisitColumn(arm), arm) + shadow_noise_;
  const double noise = NoiseOfVisit(arm, innovation, variance);
  const Eigen::VectorXd widened = VisitColumn(arm);
  Update(widened, innovation, VisitVariance(widened, arm) + noise);
}

// Learns from the innovation of a visit, and returns the squared noise for its update. All arms
// may share the innovation of a sweep's first visit. Those of later visits concern one arm each.
double RelativeCostFilter::NoiseOfVisit(uint32_t arm, double innovation, double variance) {
  const bool is_first = !std::exchange(has_visit_, true);
  std::optional<double>& last = is_first ? last_first_visit_ : last_visit_[arm];
  const double normalised = innovation / std::sqrt(variance);
  const std::optional<double> before = std::exchange(last, normalised);
  UpdateDrift(is_first ? lane_drift_ : drift_, before, normalised);
  if (IsChange(before, normalised)) {
    last = 0;
    if (is_first) {
      AddVariance(costs(), Square(innovation), 0);
    } else {
      covariance_(arm, arm) += Square(innovation);
    }
    return shadow_noise_;
  }
  const double noise = shadow_noise_ / WeightOf(normalised);
  UpdateNoise(is_first ? sweep_noise_ : shadow_noise_, normalised, variance);
  return noise;
}

// Applies a lower bound of what a complete visit would have measured. A belief far below the bound
// is treated as if the visit had measured exactly the bound.
void RelativeCostFilter::ObserveShadowBound(uint32_t arm, uint64_t sweep, double log_cost) {
  if (!has_lane()) AddLane();
  BeginSweep(sweep);
  const double innovation = VisitInnovation(arm, log_cost);
  const Eigen::VectorXd column = VisitColumn(arm);
  const double variance = VisitVariance(column, arm) + shadow_noise_;
  if (innovation > 0 && IsOutlier(innovation / std::sqrt(variance)))
    return ObserveShadow(arm, sweep, log_cost);
  has_visit_ = true;
  Truncate(column, innovation, variance);
}

// The Kalman update. `column` holds the covariances of the observed quantity with every state,
// `variance` is the variance of the innovation.
void RelativeCostFilter::Update(const Eigen::VectorXd& column, double innovation, double variance) {
  const Eigen::VectorXd gain = column / variance;
  mean_ += gain * innovation;
  covariance_.noalias() -= column * gain.transpose();
  mean_.head(arm_count_) = mean_.head(arm_count_).cwiseMax(kMinLogCost).cwiseMin(kMaxLogCost);
  covariance_.diagonal() = covariance_.diagonal().cwiseMax(0);
}

void RelativeCostFilter::Assume(uint32_t arm, double log_cost) {
  mean_[arm] = Clamped(log_cost);
  covariance_.row(arm).setZero();
  covariance_.col(arm).setZero();
  covariance_(arm, arm) = kUnknownVariance;
}

NormalBelief RelativeCostFilter::LiveCost(uint32_t arm) const {
  const double variance =
      covariance_(arm, arm) + covariance_(load(), load()) + 2 * covariance_(arm, load());
  return {mean_[arm] + mean_[load()], std::max(variance, 0.0)};
}

NormalBelief RelativeCostFilter::Difference(uint32_t a, uint32_t b) const {
  const double variance = covariance_(a, a) + covariance_(b, b) - 2 * covariance_(a, b);
  return {mean_[a] - mean_[b], std::max(variance, 0.0)};
}

double RelativeCostFilter::ResolvedVariance(uint32_t a, uint32_t b) const {
  const Eigen::VectorXd column = LiveColumn(b);
  return Square(column[a] - column[b]) / (column[b] + column[load()] + live_noise_);
}

}  // namespace sweepstake::decision
