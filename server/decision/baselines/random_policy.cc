#include "server/decision/baselines/random_policy.h"

#include "server/decision/math/random.h"
#include "server/decision/policy/choice.h"

namespace sweepstake::decision {

Choice RandomPolicy::Choose(const ChoiceInput& input) const {
  if (!IsTimeToChoose(input, cooldown_ns_)) return ChoiceOf(input.active_arm);
  const auto arm_count = static_cast<uint32_t>(posteriors().size());
  RandomStream stream(input.seed, RandomPurpose::kChoice, input.decision_id, 0);
  Choice choice = ChoiceOf(stream.NextBelow(arm_count));
  choice.propensity = 1.0 / arm_count;
  return choice;
}

}  // namespace sweepstake::decision
