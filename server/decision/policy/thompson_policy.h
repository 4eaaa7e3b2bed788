// Thompson sampling (paper §4): one draw from each arm's Beta posterior, the highest is the
// candidate.
#pragma once

#include "server/decision/policy/reward_policy.h"

namespace sweepstake::decision {

// Equal draws go to the arm that comes first.
class ThompsonPolicy : public RewardPolicy {
 public:
  using RewardPolicy::RewardPolicy;
  Choice Choose(const ChoiceInput& input) const override;
};

}  // namespace sweepstake::decision
