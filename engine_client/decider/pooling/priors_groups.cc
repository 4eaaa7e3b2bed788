#include "engine_client/decider/pooling/priors_groups.h"

#include <algorithm>
#include <vector>

#include "engine_client/decider/policy/log_cost.h"
#include "engine_client/decider/pooling/prior.h"
#include "engine_client/decider/pooling/scene_pool.h"

namespace sweepstake::decision {
namespace {

// Computes what depends on all arms of the group: `pooled` and cost_ratio.
void Compare(uint32_t reward_version, PriorsGroup& group) {
  std::vector<VersionEvidence> versions;
  for (const auto& [name, arm] : group.arms) versions.push_back({name, arm.version, arm.evidence});
  const PooledScene scene = PoolScene(versions);
  for (auto sum = scene.pooled.begin(); auto& [name, arm] : group.arms) arm.pooled = *sum++;
  const std::optional<size_t> leader = LeaderOf(scene.arms, reward_version);
  if (reward_version != kLogCostRewardVersion || !leader) return;
  const auto posterior = [](const EvidenceSum& sum) { return BetaPosterior{sum.alpha, sum.beta}; };
  for (auto& [name, arm] : group.arms) {
    if (name == versions[*leader].arm) {
      arm.cost_ratio = CostRatio{};
    } else if (arm.pooled.evidence() > 0) {
      arm.cost_ratio = CostRatioOf(posterior(arm.pooled), posterior(scene.pooled[*leader]));
    }
  }
}

}  // namespace

PriorsGroupKey GroupOf(const PriorRecord& record) {
  return {record.key.project,       record.key.scene,          record.build,
          record.key.machine_class, record.key.reward_version, record.is_quarantined,
          record.key.regime};
}

PriorsGroups GroupPriors(std::span<const PriorRecord> records, const ArmVersions& own) {
  PriorsGroups groups;
  for (const PriorRecord& record : records) {
    PriorsGroup& group = groups[GroupOf(record)];
    group.sources.insert(record.source_id);
    group.last_seen_unix_s = std::max(group.last_seen_unix_s, record.last_seen_unix_s);
    PriorsArm& arm = group.arms[record.key.arm];
    const auto known = own.find(record.key.arm);
    const uint32_t own_version = known == own.end() ? 0 : known->second;
    const uint32_t best = BestVersion(record.key.backend_version, arm.version, own_version);
    if (best != arm.version) arm = {.version = best};
    if (record.key.backend_version == best)
      arm.evidence += EvidenceBy(record.key.measured_by, record.evidence);
  }
  for (auto& [key, group] : groups) Compare(key.reward_version, group);
  return groups;
}

}  // namespace sweepstake::decision
