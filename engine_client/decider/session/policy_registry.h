// Finds policies by name. Daemons and games use ShippedPolicies(). The laboratory passes a larger
// registry (tests/laboratory/policies/study_policies.h).
#pragma once

#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "engine_client/decider/policy/policy.h"

namespace sweepstake::decision {

struct PolicyEntry {
  PolicyKind kind;
  std::unique_ptr<Policy> (*make)(const PolicySetup&);
};

using PolicyRegistry = std::span<const PolicyEntry>;

// Returns the policies that a daemon or a game can choose: `adaptive` and `paper`.
PolicyRegistry ShippedPolicies();

// Returns "default", which stands for the policy of "AI Decides", followed by the names in the
// registry's order.
std::vector<std::string_view> PolicyNames(PolicyRegistry policies);

// Returns null if no policy has this name.
const PolicyEntry* FindPolicy(std::string_view name, PolicyRegistry policies);

// REQUIRES: FindPolicy(name, policies) finds it.
const PolicyKind& PolicyKindOf(std::string_view name, PolicyRegistry policies);

// The first reward version that belongs to weights other than the default.
inline constexpr uint32_t kFirstOwnRewardVersion = 1U << 30;

// Returns the version of a policy's rewards; evidence of different versions is never merged. It is
// the reward_version of the kind. If the rewards depend on the weights and these are not the
// default, it is a hash of the weights, from kFirstOwnRewardVersion to twice that number.
uint32_t RewardVersionOf(const PolicyKind& kind, const RewardWeights& weights);

// Makes the policy of setup.options.policy. REQUIRES: FindPolicy finds it.
std::unique_ptr<Policy> MakePolicy(const PolicySetup& setup, PolicyRegistry policies);

}  // namespace sweepstake::decision
