// What each arm costs live, as one joint normal belief about the logarithms of all costs.
//
// A Kalman filter. Per arm i the state holds x_i, the log-cost on the frame thread, and b_i, by how
// much the shadow lane reads higher than that; and one offset c of the sweep under way.
//   live window of arm i:  x_i + noise
//   shadow visit of arm i: x_i + b_i + c + noise
// All x move together with the scene's load and apart by a drift of their own; the b have a common
// part, which is the lane's. So a sweep says how arms compare, a live window how much there is of
// it, and both at once what the lane's bias is.
//
// What is not known beforehand comes from the innovations: the noises from their size, the drift
// from the correlation of successive ones (R. Mehra, "On the identification of variances and
// adaptive Kalman filtering", IEEE TAC 15, 1970). Two surprises in a row on the same side (over 3
// standard deviations) are a change and widen the arm's belief; a single one is an outlier and
// counts little.
//
// Time is in decision intervals. Not thread-safe. Everything stays finite: log-costs are clamped to
// kLeastLogCost … kMostLogCost. Cost: O(n²) per observation, n arms; memory O(n²).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "server/decision/log_cost.h"

namespace sweepstake::decision {

class RelativeCostFilter {
 public:
  // Nothing known: costs of any level, apart by a factor of e or so.
  explicit RelativeCostFilter(uint32_t arm_count);

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
  NormalBelief LogCost(uint32_t arm) const;
  // Of x_a − x_b.
  NormalBelief Difference(uint32_t a, uint32_t b) const;
  double live_noise_variance() const { return live_noise_; }

 private:
  Eigen::VectorXd Sensitivity(uint32_t arm, bool shadow) const;
  void Update(const Eigen::VectorXd& sensitivity, double innovation, double innovation_variance);
  void BeginSweep(uint64_t sweep);
  void AddCommonVariance(double variance);
  double Predicted(uint32_t arm, bool shadow) const;

  uint32_t arm_count_;
  Eigen::VectorXd mean_;
  Eigen::MatrixXd covariance_;
  std::vector<std::optional<double>>
      last_innovation_;  // per arm, normalised, of its latest shadow visit
  std::optional<uint64_t> sweep_;
  bool sweep_has_reference_ = false;
  double live_noise_;
  double shadow_noise_;
  double drift_;
  double level_drift_;
  std::optional<uint32_t> live_arm_;
  double last_live_innovation_ = 0;
};

}  // namespace sweepstake::decision
