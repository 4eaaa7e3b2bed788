#include "engine_client/decider/policy/policy.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <utility>

#include "engine_client/decider/policy/diagnosis.h"

namespace sweepstake::decision {
namespace {

// Returns the number of whole cooldowns from one time to another. REQUIRES: cooldown_ns > 0.
uint64_t CooldownsBetween(int64_t from_ns, int64_t to_ns, int64_t cooldown_ns) {
  if (to_ns <= from_ns) return 0;
  // Unsigned, because the difference can exceed the range of int64_t.
  const uint64_t elapsed_ns = static_cast<uint64_t>(to_ns) - static_cast<uint64_t>(from_ns);
  return elapsed_ns / static_cast<uint64_t>(cooldown_ns);
}

}  // namespace

Diagnosis Policy::Diagnose() const { return decision::Diagnose(posteriors()); }

DecisionOptions OptionsFor(const PolicyKind& kind, DecisionOptions options) {
  if (!kind.keeps_regimes) return options;
  for (int64_t* time_ns : {&options.decision_interval_ns, &options.settling_ns})
    *time_ns = std::min(*time_ns, options.regime_interval_ns);
  return options;
}

Choice HighestOf(std::vector<double> draws) {
  assert(!draws.empty());
  Choice choice;
  const auto highest = std::max_element(draws.begin(), draws.end());
  choice.candidate = static_cast<uint32_t>(highest - draws.begin());
  choice.draws = std::move(draws);
  return choice;
}

double PropensityOfDraw(const Diagnosis& diagnosis, uint32_t arm, size_t arm_count) {
  if (diagnosis.best_probability.empty()) return 1 / static_cast<double>(arm_count);
  return std::clamp(diagnosis.best_probability[arm], std::numeric_limits<double>::min(), 1.0);
}

Choice ChoiceOf(uint32_t arm) {
  Choice choice;
  choice.candidate = arm;
  return choice;
}

bool IsTimeToChoose(const ChoiceInput& input, int64_t cooldown_ns) {
  if (input.bailed_out || cooldown_ns == 0) return true;
  if (!input.last_switch_ns && input.last_tick_ns == input.start_ns) return true;
  const int64_t since_ns = input.last_switch_ns.value_or(input.start_ns);
  return CooldownsBetween(since_ns, input.now_ns, cooldown_ns) >
         CooldownsBetween(since_ns, input.last_tick_ns, cooldown_ns);
}

}  // namespace sweepstake::decision
