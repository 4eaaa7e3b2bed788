#include "server/laboratory/ablations.h"

#include <array>

#include "server/baselines/shipped_policies.h"
#include "server/decision/policy/adaptive_policy.h"

namespace sweepstake::decision {
namespace {

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

}  // namespace

PolicyRegistry StudyPolicies() {
  static const std::vector<PolicyEntry> policies = [] {
    const PolicyRegistry shipped = ShippedPolicies();
    std::vector<PolicyEntry> all(shipped.begin(), shipped.end());
    all.insert(all.end(), kAblations.begin(), kAblations.end());
    return all;
  }();
  return policies;
}

}  // namespace sweepstake::decision
