// What choosing without any knowledge costs (`random`): any arm, each as likely as the others, once
// in a cooldown (choice.h). The one that is active already is among them.
//
// It records rewards as the paper's policy does, and makes nothing of them.
#pragma once

#include "server/decision/policy/reward_policy.h"

namespace sweepstake::decision {

class RandomPolicy : public RewardPolicy {
 public:
  explicit RandomPolicy(const PolicySetup& setup)
      : RewardPolicy(setup), cooldown_ns_(setup.options.cooldown_ns) {}

  Choice Choose(const ChoiceInput& input) const override;

 private:
  int64_t cooldown_ns_;
};

}  // namespace sweepstake::decision
