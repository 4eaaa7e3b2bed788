#include "tests/laboratory/policies/study_policies.h"

#include <array>
#include <memory>
#include <vector>

#include "engine_client/decider/policy/adaptive_policy.h"
#include "tests/laboratory/policies/lin_ts_policy.h"
#include "tests/laboratory/policies/reward_baselines.h"
#include "tests/laboratory/policies/thompson_baselines.h"

namespace sweepstake::decision {
namespace {

template <typename Kind>
std::unique_ptr<Policy> Make(const PolicySetup& setup) {
  return std::make_unique<Kind>(setup);
}

constexpr std::array kBaselines = {
    PolicyEntry{{.name = "paper-one-draw"}, Make<OneDrawPolicy>},
    PolicyEntry{{.name = "random", .explores = false}, Make<RandomPolicy>},
    PolicyEntry{{.name = "thresholds", .explores = false}, Make<ThresholdsPolicy>},
    PolicyEntry{{.name = "ucb1"}, Make<Ucb1Policy>},
    PolicyEntry{{.name = "epsilon-greedy"}, Make<EpsilonGreedyPolicy>},
    PolicyEntry{{.name = "discounted-ts"}, Make<DiscountedPolicy>},
    PolicyEntry{{.name = "lin-ts"}, Make<LinTsPolicy>},
    PolicyEntry{LaneArgminPolicy::kKind, Make<LaneArgminPolicy>},
    PolicyEntry{{.name = "calibrated", .reward_version = kLogCostRewardVersion},
                Make<CalibratedPolicy>},
};

template <AdaptiveComponents kComponents>
constexpr PolicyEntry AdaptiveWith(std::string_view name) {
  PolicyKind kind = AdaptivePolicy::kKind;
  kind.name = name;
  kind.uses_shadow = kComponents.shadow;
  return {kind, [](const PolicySetup& setup) -> std::unique_ptr<Policy> {
            return std::make_unique<AdaptivePolicy>(setup, kComponents);
          }};
}

constexpr std::array kAblations = {
    AdaptiveWith<AdaptiveComponents{.shadow = false}>("adaptive-without-shadow"),
    AdaptiveWith<AdaptiveComponents{.filter = {.calibration = false}}>(
        "adaptive-without-calibration"),
    AdaptiveWith<AdaptiveComponents{.filter = {.common_mode = false}}>(
        "adaptive-without-common-mode"),
    AdaptiveWith<AdaptiveComponents{.gate = false}>("adaptive-without-gate"),
    AdaptiveWith<AdaptiveComponents{.short_cooldown = false}>("adaptive-without-short-cooldown"),
    AdaptiveWith<AdaptiveComponents{.regimes = false}>("adaptive-without-regimes"),
};

std::vector<PolicyEntry> Joined(PolicyRegistry first, PolicyRegistry second) {
  std::vector<PolicyEntry> all(first.begin(), first.end());
  all.insert(all.end(), second.begin(), second.end());
  return all;
}

}  // namespace

PolicyRegistry ComparedPolicies() {
  static const std::vector<PolicyEntry> policies = Joined(ShippedPolicies(), kBaselines);
  return policies;
}

PolicyRegistry StudyPolicies() {
  static const std::vector<PolicyEntry> policies = Joined(ComparedPolicies(), kAblations);
  return policies;
}

}  // namespace sweepstake::decision
