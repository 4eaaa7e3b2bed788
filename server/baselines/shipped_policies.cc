#include "server/baselines/shipped_policies.h"

#include <array>
#include <memory>

#include "server/baselines/lin_ts_policy.h"
#include "server/baselines/reward_baselines.h"
#include "server/baselines/thompson_baselines.h"
#include "server/decision/policy/adaptive_policy.h"
#include "server/decision/policy/paper_policy.h"

namespace sweepstake::decision {
namespace {

template <typename Kind>
std::unique_ptr<Policy> Make(const PolicySetup& setup) {
  return std::make_unique<Kind>(setup);
}

constexpr std::array kShipped = {
    PolicyEntry{AdaptivePolicy::kKind, Make<AdaptivePolicy>},
    PolicyEntry{ThompsonPolicy::kKind, Make<ThompsonPolicy>},
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

}  // namespace

PolicyRegistry ShippedPolicies() { return kShipped; }

}  // namespace sweepstake::decision
