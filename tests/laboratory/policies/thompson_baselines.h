// Variants of the paper's Thompson sampling, as baselines: one draw per cooldown, forgetting, and
// calibrated beliefs. Exploration and cooldown are the paper's in all of them.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine_client/decider/policy/paper_policy.h"

namespace sweepstake::decision {

// The paper's policy (`paper-one-draw`) with one draw per cooldown (IsTimeToChoose), where the
// paper draws every 2 s until a draw leaves the arm. An arm that is the best with probability 0.9
// then runs some 90 % of the time instead of 57 %.
class OneDrawPolicy : public ThompsonPolicy {
 public:
  explicit OneDrawPolicy(const PolicySetup& setup)
      : ThompsonPolicy(setup), cooldown_ns_(setup.options.cooldown_ns) {}

  Choice Choose(const ChoiceInput& input) const override;

 private:
  int64_t cooldown_ns_;
};

// Thompson sampling that forgets (`discounted-ts`; V. Raj, S. Kalyani, "Taming non-stationary
// bandits: a Bayesian approach", arXiv:1707.09727, 2017). At every window the evidence of ALL arms
// is multiplied by γ before the active arm gains the new window's, so that arms without recent
// windows are drawn from nearly flat posteriors again.
//
// γ = 0.99 per window of 2 s is a memory of 100 windows, five cooldowns. A shorter memory would
// forget an arm before it can be chosen again. Loaded priors are forgotten like evidence, down to
// Beta(1,1). The stored increments are not discounted, because each reader decides how to forget.
class DiscountedPolicy : public ThompsonPolicy {
 public:
  static constexpr double kDiscount = 0.99;

  explicit DiscountedPolicy(const PolicySetup& setup)
      : ThompsonPolicy(setup), discounted_(setup.priors) {}

  std::optional<WindowUpdate> LearnWindow(const WindowObservation& observation) override;
  Increment LearnBailOut(uint32_t arm) override;
  const std::vector<BetaPosterior>& posteriors() const override { return discounted_; }

 private:
  std::vector<BetaPosterior> discounted_;
};

// The variance of one window's log-cost within an arm, pooled over the arms and inflated for the
// correlation of successive windows. The memory is bounded by the number of arms.
class PooledVariance {
 public:
  explicit PooledVariance(uint32_t arm_count) : arms_(arm_count) {}

  void Add(uint32_t arm, double log_cost);
  // Assumes a standard deviation of 5 % until there are windows.
  double value() const;

 private:
  struct Arm {
    double count = 0;
    double mean = 0;
    double last_residual = 0;
  };

  std::vector<Arm> arms_;
  double degrees_ = 0;  // degrees of freedom
  double squares_ = 0;
  double products_ = 0;  // sum of the products of successive residuals
};

// Thompson sampling on calibrated beliefs (`calibrated`). The reward is the absolute log-cost
// (log_cost.h), and each window counts as κ = max(1, μ(1−μ) ÷ σ̂²) observations, where σ̂² is the
// pooled variance; the paper counts it as one toss of a coin.
class CalibratedPolicy : public ThompsonPolicy {
 public:
  explicit CalibratedPolicy(const PolicySetup& setup);

  std::optional<WindowUpdate> LearnWindow(const WindowObservation& observation) override;
  Increment LearnBailOut(uint32_t arm) override;
  const std::vector<BetaPosterior>& posteriors() const override { return posteriors_; }
  double WindowEvidence(uint32_t arm) const override;

 private:
  double bail_out_penalty_;
  PooledVariance variance_;
  std::vector<BetaPosterior> posteriors_;
};

}  // namespace sweepstake::decision
