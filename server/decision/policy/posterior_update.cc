#include "server/decision/policy/posterior_update.h"

#include <cassert>

namespace sweepstake::decision {

Increment WindowIncrement(uint32_t arm, double reward) {
  assert(reward >= 0 && reward <= 1);
  return {.arm = arm, .alpha = reward, .beta = 1 - reward, .window_count = 1};
}

Increment BailOutIncrement(uint32_t arm, double penalty) {
  assert(penalty >= 0);
  return {.arm = arm, .beta = penalty, .bail_out_count = 1};
}

void Apply(const Increment& increment, std::span<BetaPosterior> posteriors) {
  assert(increment.arm < posteriors.size());
  posteriors[increment.arm].alpha += increment.alpha;
  posteriors[increment.arm].beta += increment.beta;
}

}  // namespace sweepstake::decision
