// What the policies that learn by the paper's reward share (paper §4): windows and bail-outs to
// Beta posteriors. How they choose is theirs.
#pragma once

#include <optional>
#include <vector>

#include "server/decision/policy/learner.h"
#include "server/decision/policy/policy.h"

namespace sweepstake::decision {

class RewardPolicy : public Policy {
 public:
  explicit RewardPolicy(const PolicySetup& setup) : learner_(setup.options, setup.priors) {}

  std::optional<Lesson> LearnWindow(const WindowObservation& observation) override {
    return learner_.LearnWindow(observation.arm, observation.window);
  }
  Increment LearnBailOut(uint32_t arm) override { return learner_.LearnBailOut(arm); }
  const std::vector<BetaPosterior>& posteriors() const override { return learner_.posteriors(); }

 private:
  Learner learner_;
};

}  // namespace sweepstake::decision
