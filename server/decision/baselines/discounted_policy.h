// Thompson sampling that forgets (`discounted-ts`; V. Raj, S. Kalyani, "Taming non-stationary
// bandits: a Bayesian approach", arXiv:1707.09727, 2017): with every window the evidence of ALL
// arms is multiplied by γ before the active arm gains the new window's, so that what was not seen
// for long is drawn from nearly flat posteriors again.
//
// γ = 0.99 per window of 2 s: a memory of 100 windows, five cooldowns. A shorter one forgets an arm
// before its turn can come again. Loaded priors are forgotten like evidence, down to Beta(1,1).
// What is made durable is the undiscounted increment, since how to forget is each reader's choice.
#pragma once

#include <vector>

#include "server/decision/policy/thompson_policy.h"

namespace sweepstake::decision {

class DiscountedPolicy : public ThompsonPolicy {
 public:
  static constexpr double kDiscount = 0.99;

  explicit DiscountedPolicy(const PolicySetup& setup)
      : ThompsonPolicy(setup), discounted_(setup.priors) {}

  std::optional<Lesson> LearnWindow(const WindowObservation& observation) override;
  Increment LearnBailOut(uint32_t arm) override;
  // The discounted ones.
  const std::vector<BetaPosterior>& posteriors() const override { return discounted_; }

 private:
  std::vector<BetaPosterior> discounted_;
};

}  // namespace sweepstake::decision
