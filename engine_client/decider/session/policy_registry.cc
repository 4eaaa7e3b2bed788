#include "engine_client/decider/session/policy_registry.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "engine_client/decider/policy/adaptive_policy.h"
#include "engine_client/decider/policy/paper_policy.h"

namespace sweepstake::decision {
namespace {

template <typename Kind>
std::unique_ptr<Policy> Make(const PolicySetup& setup) {
  return std::make_unique<Kind>(setup);
}

constexpr std::array kShipped = {
    PolicyEntry{AdaptivePolicy::kKind, Make<AdaptivePolicy>},
    PolicyEntry{ThompsonPolicy::kKind, Make<ThompsonPolicy>},
};

}  // namespace

PolicyRegistry ShippedPolicies() { return kShipped; }

std::vector<std::string_view> PolicyNames(PolicyRegistry policies) {
  std::vector<std::string_view> names = {"default"};
  for (const PolicyEntry& entry : policies) names.push_back(entry.kind.name);
  return names;
}

const PolicyEntry* FindPolicy(std::string_view name, PolicyRegistry policies) {
  const std::string_view own_name = name == "default" ? AdaptivePolicy::kKind.name : name;
  const auto entry = std::find_if(policies.begin(), policies.end(), [&](const PolicyEntry& each) {
    return each.kind.name == own_name;
  });
  return entry == policies.end() ? nullptr : &*entry;
}

const PolicyKind& PolicyKindOf(std::string_view name, PolicyRegistry policies) {
  const PolicyEntry* entry = FindPolicy(name, policies);
  assert(entry != nullptr && "Validate(options) accepts only names of the registry");
  return entry->kind;
}

std::unique_ptr<Policy> MakePolicy(const PolicySetup& setup, PolicyRegistry policies) {
  const PolicyEntry* entry = FindPolicy(setup.options.policy, policies);
  assert(entry != nullptr && "Validate(options) accepts only names of the registry");
  return entry->make(setup);
}

}  // namespace sweepstake::decision
