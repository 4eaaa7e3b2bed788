#include "engine_client/decider/policy/paper_policy.h"

#include <utility>

#include "engine_client/decider/policy/posterior_update.h"
#include "engine_client/math/random.h"

namespace sweepstake::decision {

RewardPolicy::RewardPolicy(const PolicySetup& setup)
    : weights_(setup.options.weights),
      bail_out_penalty_(setup.options.bail_out_penalty),
      posteriors_(setup.priors) {}

std::optional<WindowUpdate> RewardPolicy::LearnWindow(const WindowObservation& observation) {
  const WindowMetrics metrics = observation.window.Metrics();
  if (!metrics.IsFinite()) return std::nullopt;
  reference_.Add(metrics.fps);
  const std::optional<double> reward = Reward(metrics, reference_, weights_);
  if (!reward) return std::nullopt;
  const Increment increment = WindowIncrement(observation.arm, *reward);
  Apply(increment, posteriors_);
  return WindowUpdate{.increment = increment, .reward = *reward};
}

Increment RewardPolicy::LearnBailOut(uint32_t arm) {
  const Increment increment = BailOutIncrement(arm, bail_out_penalty_);
  Apply(increment, posteriors_);
  return increment;
}

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
