// The paper's policy (`paper`), in two steps: learning by the paper's reward, which several
// baselines share, and Thompson sampling (paper §4).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine_client/decider/policy/policy.h"
#include "engine_client/decider/policy/reward.h"

namespace sweepstake::decision {

// Turns windows and bail-outs into Beta posteriors by the paper's reward (reward.h) and update rule
// (posterior_update.h). How to choose is left to the derived class.
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

// Draws once from each arm's Beta posterior; the highest draw is the candidate, the first one of
// equals.
class ThompsonPolicy : public RewardPolicy {
 public:
  static constexpr PolicyKind kKind{.name = "paper", .blames_any_cause = true};

  using RewardPolicy::RewardPolicy;
  Choice Choose(const ChoiceInput& input) const override;
};

}  // namespace sweepstake::decision
