// Learning: windows and bail-outs to posteriors. Chooses nothing, stores nothing.
//
// Not thread-safe. Memory is bounded by the number of arms.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "server/decision/options.h"
#include "server/decision/policy/fps_reference.h"
#include "server/decision/policy/policy.h"
#include "server/decision/types.h"
#include "server/decision/window.h"

namespace sweepstake::decision {

class Learner {
 public:
  Learner(const DecisionOptions& options, std::vector<BetaPosterior> priors);

  // Window → reward → posterior of `arm`. Absent, and nothing changed, where a metric is not
  // finite. REQUIRES: !window.empty().
  std::optional<Lesson> LearnWindow(uint32_t arm, const Window& window);
  Increment LearnBailOut(uint32_t arm);

  const std::vector<BetaPosterior>& posteriors() const { return posteriors_; }

 private:
  RewardWeights weights_;
  double bail_out_penalty_;
  FpsReference reference_;
  std::vector<BetaPosterior> posteriors_;
};

}  // namespace sweepstake::decision
