// What each arm costs live, as one joint normal belief about the logarithms of all costs.
//
// A Kalman filter. Per arm i the state holds x_i, the log-cost on the frame thread, and b_i, by how
// much the shadow lane reads higher than that; and one offset c of the sweep under way.
//   live window of arm i:  x_i + noise
//   shadow visit of arm i: x_i + b_i + c + noise
// All x move together with the scene's load and apart by a drift of their own; so do the b, with
// the lane's. A sweep says how arms compare, a live window how much there is of it, and both
// together what the lane gets wrong.
//
// What is not known beforehand comes from the innovations: the noises from their size, the drifts
// from the correlation of successive ones (R. Mehra, "On the identification of variances and
// adaptive Kalman filtering", IEEE TAC 15, 1970). Two surprises in a row on the same side (over 3
// standard deviations) are a change and widen the belief; a single one is an outlier and counts
// little.
//
// Time is in decision intervals. Not thread-safe. Everything stays finite: log-costs are clamped to
// kLeastLogCost … kMostLogCost, NaN is the most. Cost: O(n²) per observation, n arms, 40 µs for a
// sweep of 32; memory O(n²).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "server/decision/policy/log_cost.h"

namespace sweepstake::decision {

// What the filter consists of, to be measured without.
struct FilterLevers {
  bool common_mode = true;  // arms, and what the lane gets wrong of them, move together
  bool calibration = true;  // noises and drifts come from the data
};

class RelativeCostFilter {
 public:
  // Nothing known: costs of any level, apart by a factor of two or so.
  explicit RelativeCostFilter(uint32_t arm_count, const FilterLevers& levers = {});

  // What is known of an arm's cost, up to a level common to all arms. To be called before anything
  // is observed.
  void SetPrior(uint32_t arm, const NormalBelief& log_cost);

  // Time passes. REQUIRES: intervals >= 0.
  void Advance(double intervals);
  void ObserveLive(uint32_t arm, double log_cost);
  // `sweep` tells sweeps apart: visits that follow each other with the same one share its offset.
  void ObserveShadow(uint32_t arm, uint64_t sweep, double log_cost);
  // The arm costs this much from now on, whatever was known of it.
  void Assume(uint32_t arm, double log_cost);

  uint32_t arm_count() const { return arm_count_; }
  NormalBelief LogCost(uint32_t arm) const { return {mean_[arm], covariance_(arm, arm)}; }
  double Covariance(uint32_t a, uint32_t b) const { return covariance_(a, b); }
  // Of x_a − x_b.
  NormalBelief Difference(uint32_t a, uint32_t b) const;
  // Variances: of a live window's noise, and by which an arm drifts from the others in an interval.
  double live_noise() const { return live_noise_; }

 private:
  uint32_t bias(uint32_t arm) const { return arm_count_ + arm; }
  uint32_t offset() const { return 2 * arm_count_; }

  void AddCommonVariance(uint32_t first_state, double variance);
  void FollowNoise(double& noise, double innovation, double variance) const;
  void FollowDrift(double& drift, double product) const;
  void BeginSweep(uint64_t sweep);
  double VisitVariance(const Eigen::VectorXd& column, uint32_t arm) const;
  double TakeReferenceVisit(double innovation, double variance);
  double TakeVisit(uint32_t arm, double innovation, double variance);
  void Update(const Eigen::VectorXd& column, double innovation, double variance);

  uint32_t arm_count_;
  FilterLevers levers_;
  Eigen::VectorXd mean_;
  Eigen::MatrixXd covariance_;

  // Variances, as they are estimated.
  double live_noise_;
  double shadow_noise_;
  double sweep_noise_;
  double drift_;
  double level_drift_;
  double lane_drift_;

  // Normalised innovations of the latest observations of their kind.
  double last_live_ = 0;
  double last_reference_ = 0;                      // of a sweep's first visit
  std::vector<std::optional<double>> last_visit_;  // per arm, of its other visits; absent: none yet

  std::optional<uint32_t> live_arm_;
  std::optional<uint64_t> sweep_;
  bool reference_visited_ = false;  // in the sweep under way
};

}  // namespace sweepstake::decision
