#include "server/decision/policy/thompson_policy.h"

#include <utility>

#include "server/decision/math/random.h"
#include "server/decision/policy/choice.h"

namespace sweepstake::decision {

Choice ThompsonPolicy::Choose(const ChoiceInput& input) const {
  std::vector<double> draws;
  draws.reserve(posteriors().size());
  for (uint32_t arm = 0; arm < posteriors().size(); ++arm) {
    RandomStream stream(input.seed, RandomPurpose::kChoice, input.decision_id, arm);
    draws.push_back(DrawBeta(posteriors()[arm], stream));
  }
  return HighestOf(std::move(draws));
}

}  // namespace sweepstake::decision
