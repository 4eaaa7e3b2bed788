// A Kalman filter that estimates what each arm costs on the frame thread. The belief is one joint
// normal distribution of the logarithms of all costs.
//
// The state has
// - x_i for each arm i: its log-cost on the frame thread
// - b_i for each arm i: the bias of the shadow lane's measurements of this arm
// - l: the load that other work puts on the core of the frame thread
// - c: an offset that all visits of the current sweep share
//
//   a live window of arm i measures  x_i + l + noise
//   a shadow visit of arm i measures x_i + b_i + c + noise
//
// All x_i share a common drift (the scene changes) and each has a small drift of its own. The same
// holds for the b_i (the lane's conditions change). A sweep thus compares the arms. A live window
// shows the level of the costs. Both together show the lane's biases. The load is never negative
// and may end at any time.
//
// Noises and drifts are estimated from the innovations: noises from their size, drifts from the
// correlation of successive ones (R. Mehra, "On the identification of variances and adaptive Kalman
// filtering", IEEE TAC 15, 1970). All noise has Student's t distribution, so that a single large
// innovation, an outlier, has little weight. Two in a row on the same side are a change and widen
// the belief.
//
// Time is measured in decision intervals. Not thread-safe. Everything stays finite: log-costs are
// clamped to kMinLogCost … kMaxLogCost, and NaN counts as the maximum. With n arms an observation
// takes O(n²) time, and the memory is O(n²).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "engine_client/decider/policy/log_cost.h"

namespace sweepstake::decision {

// The filter's components, which an ablation study can disable one by one.
struct FilterComponents {
  bool common_mode = true;  // arms' costs, and lane biases, each share a common drift
  bool heavy_tails = true;  // noise has Student's t distribution, otherwise a normal one
  bool calibration = true;  // noises and drifts are estimated from the data
};

class RelativeCostFilter {
 public:
  // Starts with a wide belief: the common level of the costs is unknown, and arms differ by a
  // factor of about two.
  explicit RelativeCostFilter(uint32_t arm_count, const FilterComponents& components = {});

  // Forgets what is known about the arms' costs. Keeps what is known about the lane, the load,
  // noises and drifts.
  void ForgetCosts();
  // Sets the prior of an arm's cost relative to the other arms. The common level of all arms stays
  // unknown. REQUIRES: nothing was observed since the construction or ForgetCosts.
  void SetPrior(uint32_t arm, const NormalBelief& log_cost);

  // Advances the time, which widens all beliefs by their drifts. REQUIRES: intervals >= 0.
  void Advance(double intervals);
  // Widens the belief about every arm's cost, because all of them may have changed.
  void Widen(double variance);
  // Learns from a live window. `lane_would_show`: the lane reports, so it would have shown a change
  // of this arm alone. A change is then attributed to the load or to the scene.
  void ObserveLive(uint32_t arm, double log_cost, bool lane_would_show = false);
  // Learns that the arm's live cost is at least `log_cost`.
  void ObserveBound(uint32_t arm, double log_cost);
  // Learns from a visit. Successive visits with the same `sweep` share an offset.
  void ObserveShadow(uint32_t arm, uint64_t sweep, double log_cost);
  // Learns from a visit that the lane cut off at its time limit. A complete visit would have
  // measured at least `log_cost`.
  void ObserveShadowBound(uint32_t arm, uint64_t sweep, double log_cost);
  // Replaces the belief about the arm's cost by this value.
  void Assume(uint32_t arm, double log_cost);

  uint32_t arm_count() const { return arm_count_; }
  NormalBelief LogCost(uint32_t arm) const { return {mean_[arm], covariance_(arm, arm)}; }
  // The belief about what a live window of the arm would measure now, x_arm + l.
  NormalBelief LiveCost(uint32_t arm) const;
  double Covariance(uint32_t a, uint32_t b) const { return covariance_(a, b); }
  // The belief about x_a − x_b.
  NormalBelief Difference(uint32_t a, uint32_t b) const;
  // By how much the next live window of arm b will reduce the variance of x_a − x_b. This is the
  // variance of the change of its mean that the window will cause.
  double ResolvedVariance(uint32_t a, uint32_t b) const;
  // By how much the lane's visits of the arm are expected to exceed its log-cost. REQUIRES: there
  // was a visit.
  double LaneBias(uint32_t arm) const { return mean_[bias(arm)]; }
  // The noise variances of a live window and of a visit of the lane.
  double live_noise() const { return VarianceOf(live_noise_); }
  double shadow_noise() const { return VarianceOf(shadow_noise_); }

 private:
  bool has_lane() const { return mean_.size() > bias(0); }
  uint32_t load() const { return arm_count_; }
  uint32_t bias(uint32_t arm) const { return load() + 1 + arm; }
  uint32_t offset() const { return bias(arm_count_); }

  auto costs() { return covariance_.topLeftCorner(arm_count_, arm_count_); }
  auto biases() { return covariance_.block(bias(0), bias(0), arm_count_, arm_count_); }
  void AddLane();
  // Adds `common` to all variances and covariances of these states, and `own` to each variance.
  // They are states of one kind: costs or biases.
  void AddVariance(Eigen::Ref<Eigen::MatrixXd> states, double common, double own) const;
  double WeightOf(double normalised) const;
  bool IsOutlier(double normalised) const;
  bool IsChange(const std::optional<double>& last, double normalised) const;
  // Returns the variance of a t distribution with this squared scale.
  double VarianceOf(double noise) const;
  void UpdateNoise(double& noise, double normalised, double variance) const;
  void UpdateDrift(double& drift, const std::optional<double>& last, double normalised) const;
  void BeginSweep(uint64_t sweep);
  Eigen::VectorXd VisitColumn(uint32_t arm) const;
  double VisitVariance(const Eigen::VectorXd& column, uint32_t arm) const;
  double VisitInnovation(uint32_t arm, double log_cost) const;
  double NoiseOfVisit(uint32_t arm, double innovation, double variance);
  Eigen::VectorXd LiveColumn(uint32_t arm) const;
  void Update(const Eigen::VectorXd& column, double innovation, double variance);
  void Truncate(const Eigen::VectorXd& column, double innovation, double variance);
  void KeepLoadPositive();

  uint32_t arm_count_;
  FilterComponents components_;
  // Mean and covariance of all states. Until the lane's first visit they hold only the costs and
  // the load, because nothing correlates the other states with them. That saves four fifths of the
  // memory and of the time of an observation.
  Eigen::VectorXd mean_;
  Eigen::MatrixXd covariance_;
  // The covariance of the lane's biases of two arms, used for all arms before the lane's first
  // visit.
  Eigen::Matrix2d first_biases_ = Eigen::Matrix2d::Zero();

  // Estimated squared scales of Student's t distributions.
  double live_noise_;
  double shadow_noise_;
  double sweep_noise_;
  // Estimated variances per decision interval.
  double drift_;
  double level_drift_;
  double lane_drift_;

  // The latest normalised innovations: of a live window, of the first visit of a sweep, and, per
  // arm, of a later visit of a sweep.
  std::optional<double> last_live_;
  std::optional<double> last_first_visit_;
  std::vector<std::optional<double>> last_visit_;

  std::optional<uint64_t> sweep_;
  bool has_visit_ = false;  // the current sweep has had its first visit
};

}  // namespace sweepstake::decision
