#include "server/decision/thompson_policy.h"

#include <algorithm>

#include "server/decision/random.h"
#include "server/decision/sampling.h"

namespace sweepstake::decision {

Choice ThompsonPolicy::Choose(const ChoiceInput& input) const {
  Choice choice;
  choice.draws.reserve(posteriors().size());
  for (uint32_t arm = 0; arm < posteriors().size(); ++arm) {
    RandomStream stream(input.seed, RandomPurpose::kChoice, input.decision_id, arm);
    choice.draws.push_back(DrawBeta(posteriors()[arm], stream));
  }
  const auto highest = std::max_element(choice.draws.begin(), choice.draws.end());
  choice.candidate = static_cast<uint32_t>(highest - choice.draws.begin());
  return choice;
}

}  // namespace sweepstake::decision
