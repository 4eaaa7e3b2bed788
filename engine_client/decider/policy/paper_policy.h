// The paper's policy (`paper`), in two classes: RewardPolicy learns from the paper's reward and is
// also the base of several baselines; ThompsonPolicy adds the choice by Thompson sampling (paper
// §4).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine_client/decider/policy/policy.h"
#include "engine_client/decider/policy/reward.h"

namespace sweepstake::decision {

// Turns windows and bail-outs into Beta posteriors by the paper's reward (reward.h) and update rule
// (posterior_update.h). A derived class chooses the arm.
class RewardPolicy : public Policy {
 public:
  explicit RewardPolicy(const PolicySetup& setup);

  std::optional<WindowUpdate> LearnWindow(const WindowObservation& observation) override;
  Increment LearnBailOut(uint32_t arm) override;
  const std::vector<BetaPosterior>& posteriors() const override { return posteriors_; }

 private:
  RewardWeights weights_;
  double bail_out_penalty_;
  FpsReference reference_;
  std::vector<BetaPosterior> posteriors_;
};

// Draws once from each arm's Beta posterior. The arm with the highest draw is the candidate; the
// first one if several have it.
class ThompsonPolicy : public RewardPolicy {
 public:
  static constexpr PolicyKind kKind{
      .name = "paper", .draws_from_posteriors = true, .counts_any_cause = true};

  using RewardPolicy::RewardPolicy;
  Choice Choose(const ChoiceInput& input) const override;
};

}  // namespace sweepstake::decision
