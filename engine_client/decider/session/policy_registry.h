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

// Makes the policy of setup.options.policy. REQUIRES: FindPolicy finds it.
std::unique_ptr<Policy> MakePolicy(const PolicySetup& setup, PolicyRegistry policies);

}  // namespace sweepstake::decision
