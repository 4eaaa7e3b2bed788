// Thompson sampling by the paper's rules on calibrated beliefs (`calibrated`): the absolute
// log-cost as reward (log_cost.h), and each window with the evidence that its own noise warrants,
// κ = max(1, μ(1−μ) ÷ σ̂²), where the paper counts it as one toss of a coin.
//
// σ̂² is the variance of windows within an arm, pooled over the arms and inflated for the
// correlation of successive windows. Exploration, cooldown and the draws are the paper's.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "server/decision/policy/thompson_policy.h"

namespace sweepstake::decision {

// Variance of a mean of windows, times their number, pooled over the arms. Bounded memory.
class PooledVariance {
 public:
  explicit PooledVariance(uint32_t arm_count) : arms_(arm_count) {}

  void Add(uint32_t arm, double log_cost);
  // Of one window; a window's noise is taken as 5 % until there are windows to tell.
  double value() const;

 private:
  struct Arm {
    double count = 0;
    double mean = 0;
    double last_residual = 0;
  };

  std::vector<Arm> arms_;
  double freedom_ = 0;
  double squares_ = 0;
  double products_ = 0;  // of successive residuals
};

class CalibratedPolicy : public ThompsonPolicy {
 public:
  explicit CalibratedPolicy(const PolicySetup& setup);

  std::optional<Lesson> LearnWindow(const WindowObservation& observation) override;
  Increment LearnBailOut(uint32_t arm) override;
  const std::vector<BetaPosterior>& posteriors() const override { return posteriors_; }

 private:
  double bail_out_penalty_;
  PooledVariance variance_;
  std::vector<BetaPosterior> posteriors_;
};

}  // namespace sweepstake::decision
