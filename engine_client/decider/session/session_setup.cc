#include "engine_client/decider/session/session_setup.h"

#include <algorithm>
#include <set>

#include "engine_client/text/names.h"

namespace sweepstake::decision {
namespace {

using Problem = std::optional<std::string>;

Problem CheckArms(const SessionSetup& setup) {
  if (setup.arms.empty() || setup.arms.size() > kMaxArms) {
    return "there are " + std::to_string(setup.arms.size()) + " arms; announce 1 to " +
           std::to_string(kMaxArms);
  }
  std::set<std::string> seen;
  for (const std::string& arm : setup.arms) {
    if (arm.empty()) return "an arm has an empty name; give every arm a name";
    if (!seen.insert(arm).second)
      return "the arm \"" + arm + "\" occurs twice; give every arm a different name";
  }
  if (setup.active_arm >= setup.arms.size())
    return "the active arm is not in the list of arms; use its index there";
  if (setup.initial_arm >= setup.arms.size())
    return "the initial arm is not in the list of arms; use its index there";
  if (setup.explored_arm_count > setup.arms.size())
    return "explored_arm_count exceeds the number of arms; use at most that number";
  return std::nullopt;
}

bool IsUsable(const BetaPosterior& prior) {
  return prior.alpha > 0 && prior.alpha < kMaxPriorEvidence && prior.beta > 0 &&
         prior.beta < kMaxPriorEvidence;
}

Problem CheckPriors(const SessionSetup& setup) {
  if (!setup.priors.empty() && setup.priors.size() != setup.arms.size()) {
    return "there are " + std::to_string(setup.priors.size()) + " priors for " +
           std::to_string(setup.arms.size()) + " arms; give one per arm, or none";
  }
  for (size_t arm = 0; arm < setup.priors.size(); ++arm) {
    if (!IsUsable(setup.priors[arm])) {
      return "the prior of \"" + setup.arms[arm] +
             "\" is out of range; use alpha and beta above 0 and below 1e15";
    }
  }
  return std::nullopt;
}

Problem CheckRegimePriors(const SessionSetup& setup) {
  const RegimePriors& regimes = setup.regime_priors;
  if (regimes.buckets.size() > kMaxRegimePriors || regimes.stored_count > regimes.buckets.size() ||
      regimes.posteriors.size() != regimes.buckets.size() * setup.arms.size())
    return "the priors of the regimes have wrong numbers; give one per arm for each of at most " +
           std::to_string(kMaxRegimePriors) + " regimes";
  std::set<std::string> seen;
  for (const std::string& bucket : regimes.buckets) {
    if (bucket.empty() || !MiddleOf(bucket) || !seen.insert(bucket).second)
      return "regime " + std::to_string(seen.size()) + " has no valid name, or occurs twice";
  }
  if (!std::all_of(regimes.posteriors.begin(), regimes.posteriors.end(), IsUsable))
    return "a prior of a regime is out of range; use alpha and beta above 0 and below 1e15";
  return std::nullopt;
}

}  // namespace

std::vector<std::string> Problems(const DecisionOptions& options, PolicyRegistry policies) {
  std::vector<std::string> problems = NumberProblems(options);
  if (FindPolicy(options.policy, policies) == nullptr) {
    problems.insert(problems.begin(),
                    text::UnknownName("policy", options.policy, PolicyNames(policies)));
  }
  return problems;
}

std::optional<std::string> Validate(const DecisionOptions& options, PolicyRegistry policies) {
  const std::vector<std::string> problems = Problems(options, policies);
  if (problems.empty()) return std::nullopt;
  return problems.front();
}

std::optional<std::string> Validate(const SessionSetup& setup, PolicyRegistry policies) {
  if (Problem problem = Validate(setup.options, policies)) return problem;
  if (Problem problem = CheckArms(setup)) return problem;
  if (Problem problem = CheckPriors(setup)) return problem;
  if (Problem problem = CheckRegimePriors(setup)) return problem;
  if (setup.mode != Mode::kManual && setup.mode != Mode::kAi)
    return "unknown mode; use 1 (manual) or 2 (AI)";
  return std::nullopt;
}

}  // namespace sweepstake::decision
