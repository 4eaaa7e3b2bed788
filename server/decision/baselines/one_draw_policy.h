// The paper's policy without its redrawing until a draw leaves the arm (`paper-one-draw`): Thompson
// sampling that draws once in a cooldown (choice.h) and keeps the arm in between.
//
// An arm that is best with probability 0.9 then runs some 90 % of the time; drawing every 2 s, as
// the paper does, it runs 57 %.
#pragma once

#include "server/decision/policy/thompson_policy.h"

namespace sweepstake::decision {

class OneDrawPolicy : public ThompsonPolicy {
 public:
  explicit OneDrawPolicy(const PolicySetup& setup)
      : ThompsonPolicy(setup), cooldown_ns_(setup.options.cooldown_ns) {}

  Choice Choose(const ChoiceInput& input) const override;

 private:
  int64_t cooldown_ns_;
};

}  // namespace sweepstake::decision
