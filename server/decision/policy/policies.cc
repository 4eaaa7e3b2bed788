// The registry of policies: names (options.h) and what they stand for (policy.h).
#include <algorithm>
#include <array>
#include <cassert>
#include <memory>
#include <string_view>

#include "server/decision/baselines/calibrated_policy.h"
#include "server/decision/baselines/discounted_policy.h"
#include "server/decision/baselines/epsilon_greedy_policy.h"
#include "server/decision/baselines/lin_ts_policy.h"
#include "server/decision/baselines/one_draw_policy.h"
#include "server/decision/baselines/random_policy.h"
#include "server/decision/baselines/thresholds_policy.h"
#include "server/decision/baselines/ucb1_policy.h"
#include "server/decision/diagnosis.h"
#include "server/decision/options.h"
#include "server/decision/policy/adaptive_policy.h"
#include "server/decision/policy/policy.h"
#include "server/decision/policy/thompson_policy.h"

namespace sweepstake::decision {
namespace {

using Factory = std::unique_ptr<Policy> (*)(const PolicySetup&);

template <typename Kind>
std::unique_ptr<Policy> Make(const PolicySetup& setup) {
  return std::make_unique<Kind>(setup);
}

struct Entry {
  PolicyKind kind;
  Factory make;
};

// The one called "default" is an entry as well, under its own name.
constexpr std::string_view kDefaultPolicy = "adaptive";

constexpr PolicyKind kAdaptive = {.name = "adaptive",
                                  .reward_version = 2,
                                  .explores = false,
                                  .starts_from_priors = true,
                                  .uses_shadow = true};

template <AdaptiveLevers kLevers>
constexpr Entry Without(std::string_view name) {
  PolicyKind kind = kAdaptive;
  kind.name = name;
  kind.uses_shadow = kLevers.shadow;
  return {kind, [](const PolicySetup& setup) -> std::unique_ptr<Policy> {
            return std::make_unique<AdaptivePolicy>(setup, kLevers);
          }};
}

constexpr std::array kEntries = {
    Entry{kAdaptive, Make<AdaptivePolicy>},
    Entry{{.name = "paper"}, Make<ThompsonPolicy>},
    Entry{{.name = "paper-one-draw"}, Make<OneDrawPolicy>},
    Entry{{.name = "random", .explores = false}, Make<RandomPolicy>},
    Entry{{.name = "thresholds", .explores = false}, Make<ThresholdsPolicy>},
    Entry{{.name = "ucb1"}, Make<Ucb1Policy>},
    Entry{{.name = "epsilon-greedy"}, Make<EpsilonGreedyPolicy>},
    Entry{{.name = "discounted-ts"}, Make<DiscountedPolicy>},
    Entry{{.name = "lin-ts"}, Make<LinTsPolicy>},
    Entry{{.name = "calibrated", .reward_version = 2}, Make<CalibratedPolicy>},
    // What each part of `adaptive` is worth (`sweepstake replay`).
    Without<AdaptiveLevers{.shadow = false}>("adaptive-without-shadow"),
    Without<AdaptiveLevers{.filter = {.calibration = false}}>("adaptive-without-calibration"),
    Without<AdaptiveLevers{.filter = {.common_mode = false}}>("adaptive-without-common-mode"),
    Without<AdaptiveLevers{.gate = false}>("adaptive-without-gate"),
    Without<AdaptiveLevers{.short_cooldown = false}>("adaptive-without-short-cooldown"),
};

constexpr auto kNames = [] {
  std::array<std::string_view, kEntries.size() + 1> names = {"default"};
  for (size_t i = 0; i < kEntries.size(); ++i) names[i + 1] = kEntries[i].kind.name;
  return names;
}();

const Entry& EntryOf(std::string_view name) {
  const std::string_view own = name == "default" ? kDefaultPolicy : name;
  const auto entry = std::find_if(kEntries.begin(), kEntries.end(),
                                  [&](const Entry& each) { return each.kind.name == own; });
  assert(entry != kEntries.end() && "Validate(options) lets only known policies through");
  return *entry;
}

}  // namespace

std::span<const std::string_view> PolicyNames() { return kNames; }

Diagnosis Policy::Diagnose() const { return decision::Diagnose(posteriors()); }

const PolicyKind& PolicyKindOf(std::string_view name) { return EntryOf(name).kind; }

std::unique_ptr<Policy> MakePolicy(const PolicySetup& setup) {
  return EntryOf(setup.options.policy).make(setup);
}

}  // namespace sweepstake::decision
