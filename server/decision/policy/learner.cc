#include "server/decision/policy/learner.h"

#include <utility>

#include "server/decision/policy/posterior_update.h"
#include "server/decision/policy/reward.h"

namespace sweepstake::decision {

Learner::Learner(const DecisionOptions& options, std::vector<BetaPosterior> priors)
    : weights_(options.weights),
      bail_out_penalty_(options.bail_out_penalty),
      posteriors_(std::move(priors)) {}

std::optional<Lesson> Learner::LearnWindow(uint32_t arm, const Window& window) {
  const WindowMetrics metrics = window.Metrics();
  if (!metrics.IsFinite()) return std::nullopt;
  reference_.Add(metrics.fps);
  const std::optional<double> reward = Reward(metrics, reference_, weights_);
  if (!reward) return std::nullopt;
  const Increment increment = WindowIncrement(arm, *reward);
  Apply(increment, posteriors_);
  return Lesson{.increment = increment, .reward = *reward};
}

Increment Learner::LearnBailOut(uint32_t arm) {
  const Increment increment = BailOutIncrement(arm, bail_out_penalty_);
  Apply(increment, posteriors_);
  return increment;
}

}  // namespace sweepstake::decision
