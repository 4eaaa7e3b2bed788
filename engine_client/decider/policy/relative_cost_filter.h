// A Kalman filter that estimates what each arm costs live, as one joint normal belief about the
// logarithms of all costs.
//
// For each arm i the state holds x_i, the log-cost on the frame thread, and b_i, the bias of the
// shadow lane's measurements of this arm; in addition it holds the load l that other work puts on
// the core of the frame thread, and one offset c of the current sweep.
//   a live window of arm i measures  x_i + l + noise
//   a shadow visit of arm i measures x_i + b_i + c + noise
// All x_i share the drift of the scene's load and have a drift of their own besides; the b_i do so
// with the lane's drift. A sweep thus compares the arms, a live window gives the level of the
// costs, and both together the lane's biases. The load is never negative, and may end at any
// moment.
//
// Noises and drifts are estimated from the innovations: noises from their size, drifts from the
// correlation of successive ones (R. Mehra, "On the identification of variances and adaptive Kalman
// filtering", IEEE TAC 15, 1970). Two successive innovations of more than 3 standard deviations on
// the same side are a change and widen the belief; a single one is an outlier and has little
// weight.
//
// Time is in decision intervals. Not thread-safe. Everything stays finite: log-costs are clamped to
// kMinLogCost … kMaxLogCost, and NaN counts as the maximum. With n arms an observation takes O(n²)
// time, and the memory is O(n²).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "engine_client/decider/policy/log_cost.h"

namespace sweepstake::decision {

// The filter's components, which an ablation study can disable one by one.
struct FilterComponents {
  bool common_mode = true;  // the arms' costs, and the lane's biases, share a common drift
  bool calibration = true;  // noises and drifts are estimated from the data
};

class RelativeCostFilter {
 public:
  // Begins with costs of any level that differ by a factor of about two.
  explicit RelativeCostFilter(uint32_t arm_count, const FilterComponents& components = {});

  // Sets the prior of an arm's cost, up to a level common to all arms. REQUIRES: nothing was
  // observed yet.
  void SetPrior(uint32_t arm, const NormalBelief& log_cost);

  // Lets time pass. REQUIRES: intervals >= 0.
  void Advance(double intervals);
  // Every arm's cost may have changed.
  void Widen(double variance);
  // A change is not attributed to this arm alone if the lane would have shown it.
  void ObserveLive(uint32_t arm, double log_cost, bool lane_would_show = false);
  // The value is a lower bound of the arm's live cost.
  void ObserveBound(uint32_t arm, double log_cost);
  // Successive visits with the same `sweep` share that sweep's offset.
  void ObserveShadow(uint32_t arm, uint64_t sweep, double log_cost);
  // A visit that a cap ended. The value is a lower bound of the complete visit's cost.
  void ObserveShadowBound(uint32_t arm, uint64_t sweep, double log_cost);
  // Replaces the belief about the arm's cost by this value.
  void Assume(uint32_t arm, double log_cost);

  uint32_t arm_count() const { return arm_count_; }
  NormalBelief LogCost(uint32_t arm) const { return {mean_[arm], covariance_(arm, arm)}; }
  // The belief about a live window of the arm now: its cost with the load of the core.
  NormalBelief LiveCost(uint32_t arm) const;
  double Covariance(uint32_t a, uint32_t b) const { return covariance_(a, b); }
  // The belief about x_a − x_b.
  NormalBelief Difference(uint32_t a, uint32_t b) const;
  // The expected difference between the lane's visits of the arm and its cost. REQUIRES: there was
  // a visit.
  double LaneBias(uint32_t arm) const { return mean_[bias(arm)]; }
  // The noise variances of a live window and of a visit.
  double live_noise() const { return live_noise_; }
  double shadow_noise() const { return shadow_noise_; }

 private:
  bool has_lane() const { return mean_.size() > bias(0); }
  uint32_t load() const { return arm_count_; }
  uint32_t bias(uint32_t arm) const { return load() + 1 + arm; }
  uint32_t offset() const { return bias(arm_count_); }

  auto costs() { return covariance_.topLeftCorner(arm_count_, arm_count_); }
  auto biases() { return covariance_.block(bias(0), bias(0), arm_count_, arm_count_); }
  void AddLane();
  // Adds variances to states of one kind: a common one, and one for each state.
  void AddVariance(Eigen::Ref<Eigen::MatrixXd> states, double common, double own) const;
  void UpdateNoise(double& noise, double innovation, double variance) const;
  void UpdateDrift(double& drift, double product) const;
  void BeginSweep(uint64_t sweep);
  Eigen::VectorXd VisitColumn(uint32_t arm) const;
  double VisitVariance(const Eigen::VectorXd& column, uint32_t arm) const;
  double VisitInnovation(uint32_t arm, double log_cost) const;
  double NoiseOfReferenceVisit(double innovation, double variance);
  double NoiseOfVisit(uint32_t arm, double innovation, double variance);
  Eigen::VectorXd LiveColumn(uint32_t arm) const;
  void Update(const Eigen::VectorXd& column, double innovation, double variance);
  void Truncate(const Eigen::VectorXd& column, double innovation, double variance);
  void KeepLoadPositive();

  uint32_t arm_count_;
  FilterComponents components_;
  // Mean and covariance of all states. Before the lane's first visit they hold only the costs and
  // the load, because nothing ties the other states to them until then. This saves four fifths of
  // the memory, and of the time of an observation.
  Eigen::VectorXd mean_;
  Eigen::MatrixXd covariance_;
  // The covariance of the lane's biases of any two arms, before its first visit.
  Eigen::Matrix2d first_biases_ = Eigen::Matrix2d::Zero();

  // Estimated variances.
  double live_noise_;
  double shadow_noise_;
  double sweep_noise_;
  double drift_;
  double level_drift_;
  double lane_drift_;

  // Normalised innovations of the latest live window, of the latest first visit of a sweep, and,
  // per arm, of its latest other visit.
  double last_live_ = 0;
  double last_reference_ = 0;
  std::vector<std::optional<double>> last_visit_;

  std::optional<uint32_t> live_arm_;
  std::optional<uint64_t> sweep_;
  bool reference_visited_ = false;  // the current sweep has visited the reference
};

}  // namespace sweepstake::decision
