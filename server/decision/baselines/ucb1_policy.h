// UCB1 (P. Auer, N. Cesa-Bianchi, P. Fischer, "Finite-time analysis of the multiarmed bandit
// problem", Machine Learning 47, 2002): the arm with the highest
//
//   x̄ + √(2 ln n / nₐ),
//
// x̄ an arm's mean reward, nₐ its windows, n those of all arms. Mean and count are the posterior's
// μ and α+β, so that loaded priors and bail-outs count as what they say; the flat prior counts as
// two windows of reward ½. No randomness: it is asked at every tick, and only the cooldown holds it
// back.
#pragma once

#include "server/decision/policy/reward_policy.h"

namespace sweepstake::decision {

class Ucb1Policy : public RewardPolicy {
 public:
  using RewardPolicy::RewardPolicy;
  // The draws are the bounds; equal ones go to the arm that comes first.
  Choice Choose(const ChoiceInput& input) const override;
};

}  // namespace sweepstake::decision
