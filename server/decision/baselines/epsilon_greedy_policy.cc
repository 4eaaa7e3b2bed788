#include "server/decision/baselines/epsilon_greedy_policy.h"

#include <utility>

#include "server/decision/math/random.h"
#include "server/decision/policy/choice.h"

namespace sweepstake::decision {

Choice EpsilonGreedyPolicy::Choose(const ChoiceInput& input) const {
  if (!IsTimeToChoose(input, cooldown_ns_)) return ChoiceOf(input.active_arm);
  std::vector<double> means;
  for (const BetaPosterior& posterior : posteriors()) means.push_back(posterior.mean());
  const auto arm_count = static_cast<uint32_t>(means.size());
  Choice choice = HighestOf(std::move(means));
  const uint32_t greedy = choice.candidate;
  RandomStream stream(input.seed, RandomPurpose::kChoice, input.decision_id, 0);
  if (stream.NextUniform() < kEpsilon) choice.candidate = stream.NextBelow(arm_count);
  choice.propensity = kEpsilon / arm_count + (choice.candidate == greedy ? 1 - kEpsilon : 0);
  return choice;
}

}  // namespace sweepstake::decision
