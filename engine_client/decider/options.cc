#include "engine_client/decider/options.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>
#include <utility>

namespace sweepstake::decision {
namespace {

using Problem = std::optional<std::string>;

int64_t Divided(int64_t interval_ns, double time_scale) {
  const double scaled = static_cast<double>(interval_ns) / time_scale;
  // Keeps a positive interval positive. An interval of 0 has its own meaning ("off") or is invalid.
  return interval_ns > 0 ? std::max<int64_t>(1, static_cast<int64_t>(scaled)) : interval_ns;
}

Problem CheckWeights(const RewardWeights& weights) {
  const double all[] = {weights.fps, weights.detection, weights.memory, weights.checks};
  double sum = 0;
  for (const double weight : all) {
    if (!std::isfinite(weight) || weight < 0)
      return "a reward weight is negative or not finite; use numbers from 0 to 1";
    sum += weight;
  }
  if (std::abs(sum - 1) > 1e-9)
    return "the reward weights sum to " + std::to_string(sum) + "; make them sum to 1";
  return std::nullopt;
}

Problem CheckInterval(const char* name, int64_t value_ns, int64_t min_ns) {
  if (value_ns < min_ns) {
    return std::string(name) + " is " + std::to_string(value_ns) + "; use " +
           std::to_string(min_ns) + " or more";
  }
  if (value_ns > kMaxIntervalNs) {
    return std::string(name) + " is " + std::to_string(value_ns) + "; use at most " +
           std::to_string(kMaxIntervalNs) + " (100 days)";
  }
  return std::nullopt;
}

void CheckIntervals(const DecisionOptions& options, std::vector<std::string>& problems) {
  const struct {
    const char* name;
    int64_t value_ns;
    int64_t min_ns;
  } intervals[] = {
      {"decision_interval_ns", options.decision_interval_ns, 1},
      {"cooldown_ns", options.cooldown_ns, 0},
      {"settling_ns", options.settling_ns, 0},
      {"bail_out_ns", options.bail_out_ns, 1},
      {"exploration_warm_up_ns", options.exploration_warm_up_ns, 0},
      {"exploration_measure_ns", options.exploration_measure_ns, 1},
  };
  for (const auto& interval : intervals) {
    if (Problem problem = CheckInterval(interval.name, interval.value_ns, interval.min_ns))
      problems.push_back(*std::move(problem));
  }
}

}  // namespace

DecisionOptions DecisionOptions::Scaled(double time_scale) const {
  assert(time_scale >= 1 && time_scale <= 1000);
  DecisionOptions scaled = *this;
  scaled.decision_interval_ns = Divided(decision_interval_ns, time_scale);
  scaled.cooldown_ns = Divided(cooldown_ns, time_scale);
  scaled.settling_ns = Divided(settling_ns, time_scale);
  scaled.regime_interval_ns = Divided(regime_interval_ns, time_scale);
  scaled.exploration_warm_up_ns = Divided(exploration_warm_up_ns, time_scale);
  scaled.exploration_measure_ns = Divided(exploration_measure_ns, time_scale);
  return scaled;
}

DecisionOptions DecisionOptions::With(const DecisionRules& rules) const {
  const auto set = [](const std::optional<uint64_t>& given_ns, int64_t& interval_ns) {
    if (given_ns)
      interval_ns = static_cast<int64_t>(std::min(*given_ns, uint64_t{kMaxIntervalNs} + 1));
  };
  DecisionOptions changed = *this;
  changed.weights = rules.weights.value_or(weights);
  set(rules.decision_interval_ns, changed.decision_interval_ns);
  set(rules.cooldown_ns, changed.cooldown_ns);
  set(rules.settling_ns, changed.settling_ns);
  return changed;
}

std::vector<std::string> NumberProblems(const DecisionOptions& options) {
  std::vector<std::string> problems;
  if (Problem problem = CheckWeights(options.weights)) problems.push_back(*std::move(problem));
  CheckIntervals(options, problems);
  if (!(options.bail_out_penalty >= 0 && options.bail_out_penalty <= kMaxPenalty)) {
    problems.emplace_back(
        "bail_out_penalty is negative, not finite or huge; use a number from 0 to 1000000");
  }
  if (!(options.fps_floor >= 0 && options.fps_floor <= kLargestFpsFloor))
    problems.emplace_back("fps_floor is negative, not finite or huge; use a number from 0 to 1000");
  return problems;
}

}  // namespace sweepstake::decision
