// ε-greedy (R. Sutton, A. Barto, "Reinforcement Learning", 2nd ed., §2.4): the arm with the highest
// mean reward, but with probability ε any arm, each as likely as the others.
//
// ε = 0.1 and stays, the book's usual value: a decaying ε would have done its exploring within the
// first of some 22 choices that a run of 15 minutes has. One choice in a cooldown (choice.h), since
// a coin tossed every 2 s until it says "leave" would make of ε = 0.1 a share of 88 % over 20
// ticks.
#pragma once

#include "server/decision/policy/reward_policy.h"

namespace sweepstake::decision {

class EpsilonGreedyPolicy : public RewardPolicy {
 public:
  static constexpr double kEpsilon = 0.1;

  explicit EpsilonGreedyPolicy(const PolicySetup& setup)
      : RewardPolicy(setup), cooldown_ns_(setup.options.cooldown_ns) {}

  // The draws are the means; of equal ones the first arm is the greedy one.
  Choice Choose(const ChoiceInput& input) const override;

 private:
  int64_t cooldown_ns_;
};

}  // namespace sweepstake::decision
