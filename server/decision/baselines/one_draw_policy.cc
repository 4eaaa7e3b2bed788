#include "server/decision/baselines/one_draw_policy.h"

#include "server/decision/policy/choice.h"

namespace sweepstake::decision {

Choice OneDrawPolicy::Choose(const ChoiceInput& input) const {
  return IsTimeToChoose(input, cooldown_ns_) ? ThompsonPolicy::Choose(input)
                                             : ChoiceOf(input.active_arm);
}

}  // namespace sweepstake::decision
