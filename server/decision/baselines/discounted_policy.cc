#include "server/decision/baselines/discounted_policy.h"

#include "server/decision/policy/posterior_update.h"

namespace sweepstake::decision {

std::optional<Lesson> DiscountedPolicy::LearnWindow(const WindowObservation& observation) {
  const std::optional<Lesson> lesson = ThompsonPolicy::LearnWindow(observation);
  if (!lesson) return lesson;
  for (BetaPosterior& posterior : discounted_) {
    posterior.alpha = 1 + kDiscount * (posterior.alpha - 1);
    posterior.beta = 1 + kDiscount * (posterior.beta - 1);
  }
  Apply(lesson->increment, discounted_);
  return lesson;
}

Increment DiscountedPolicy::LearnBailOut(uint32_t arm) {
  const Increment increment = ThompsonPolicy::LearnBailOut(arm);
  Apply(increment, discounted_);
  return increment;
}

}  // namespace sweepstake::decision
