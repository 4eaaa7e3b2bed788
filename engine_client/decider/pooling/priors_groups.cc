#include "engine_client/decider/pooling/priors_groups.h"

#include <algorithm>
#include <vector>

#include "engine_client/decider/policy/log_cost.h"
#include "engine_client/decider/pooling/prior.h"

namespace sweepstake::decision {
namespace {

void AddTo(const PriorRecord& record, PriorsArm& arm) {
  const bool by_lane = record.key.measured_by == kLaneName;
  EvidenceSum& sum = by_lane ? arm.evidence.lane : arm.evidence.live;
  sum.alpha += record.evidence.alpha;
  sum.beta += record.evidence.beta;
  if (!by_lane) arm.evidence.bail_out_count += record.evidence.bail_out_count;
  (by_lane ? arm.visit_count : arm.window_count) += record.evidence.window_count;
}

double MeanReward(const EvidenceSum& sum) { return sum.alpha / sum.evidence(); }

void FillPooled(PriorsGroup& group) {
  std::vector<ArmEvidence> evidence;
  for (const auto& [name, arm] : group.arms) evidence.push_back(arm.evidence);
  const std::vector<EvidenceSum> pooled = PoolEvidence(evidence);
  for (auto sum = pooled.begin(); auto& [name, arm] : group.arms) arm.pooled = *sum++;
}

// Computes the cost ratio of each arm. REQUIRES: `pooled` of each arm is set, and rewards depend
// only on the cost.
void FillCostRatios(PriorsGroup& group) {
  const PriorsArm* cheapest = nullptr;
  for (const auto& [name, arm] : group.arms) {
    if (arm.pooled.evidence() > 0 &&
        (cheapest == nullptr || MeanReward(arm.pooled) > MeanReward(cheapest->pooled)))
      cheapest = &arm;
  }
  const auto posterior = [](const PriorsArm& arm) {
    return BetaPosterior{arm.pooled.alpha, arm.pooled.beta};
  };
  for (auto& [name, arm] : group.arms) {
    if (arm.pooled.evidence() > 0)
      arm.cost_ratio =
          &arm == cheapest ? CostRatio{} : CostRatioOf(posterior(arm), posterior(*cheapest));
  }
}

}  // namespace

PriorsGroupKey GroupOf(const PriorRecord& record) {
  return {record.key.project,       record.key.scene,          record.build,
          record.key.machine_class, record.key.reward_version, record.is_quarantined};
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
    if (IsBetterVersion(record.key.backend_version, arm.version, own_version))
      arm = {.version = record.key.backend_version};
    if (record.key.backend_version == arm.version) AddTo(record, arm);
  }
  for (auto& [key, group] : groups) {
    FillPooled(group);
    if (key.reward_version == kLogCostRewardVersion) FillCostRatios(group);
  }
  return groups;
}

}  // namespace sweepstake::decision
