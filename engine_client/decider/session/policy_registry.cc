#include "engine_client/decider/session/policy_registry.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>

#include "engine_client/decider/policy/adaptive_policy.h"
#include "engine_client/decider/policy/log_cost.h"
#include "engine_client/decider/policy/paper_policy.h"
#include "engine_client/math/hash.h"

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

uint32_t RewardVersionOf(const PolicyKind& kind, const RewardWeights& weights) {
  if (kind.goes_by_cost() || weights == RewardWeights()) return kind.reward_version;
  uint64_t hash = kind.reward_version;
  for (const double weight : {weights.fps, weights.detection, weights.memory, weights.checks})
    hash = math::Mix64(hash ^ std::bit_cast<uint64_t>(weight + 0.0));  // -0 becomes 0
  return kFirstOwnRewardVersion | static_cast<uint32_t>(hash % kFirstOwnRewardVersion);
}

std::unique_ptr<Policy> MakePolicy(const PolicySetup& setup, PolicyRegistry policies) {
  const PolicyEntry* entry = FindPolicy(setup.options.policy, policies);
  assert(entry != nullptr && "Validate(options) accepts only names of the registry");
  return entry->make(setup);
}

}  // namespace sweepstake::decision
