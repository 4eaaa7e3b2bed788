#include "engine_client/cli/priors/priors_groups.h"

#include <algorithm>
#include <cmath>

#include "engine_client/decider/policy/log_cost.h"
#include "engine_client/decider/pooling/prior.h"

namespace sweepstake::cli {
namespace {

void Add(const PriorRecord& record, PriorsArm& arm) {
  const bool by_lane = record.key.measured_by == decision::kLaneName;
  decision::EvidenceSum& sum = by_lane ? arm.evidence.lane : arm.evidence.live;
  sum.alpha += record.evidence.alpha;
  sum.beta += record.evidence.beta;
  if (!by_lane) arm.evidence.bail_out_count += record.evidence.bail_out_count;
  (by_lane ? arm.visit_count : arm.window_count) += record.evidence.window_count;
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
    if (decision::IsBetterVersion(record.key.backend_version, arm.version, own_version))
      arm = {.version = record.key.backend_version};
    if (record.key.backend_version == arm.version) Add(record, arm);
  }
  return groups;
}

std::vector<ArmRatio> CostsOf(const PriorsGroup& group) {
  std::vector<decision::ArmEvidence> evidence;
  for (const auto& [name, arm] : group.arms) evidence.push_back(arm.evidence);
  const std::vector<decision::EvidenceSum> pooled = decision::PoolEvidence(evidence);
  std::vector<ArmRatio> costs;
  double least = 0;
  for (auto arm = group.arms.begin(); const decision::EvidenceSum& sum : pooled) {
    const std::string& name = (arm++)->first;
    if (!(sum.evidence() > 0)) continue;
    const double log_cost = decision::LogCostOfReward(sum.alpha / sum.evidence());
    least = costs.empty() ? log_cost : std::min(least, log_cost);
    costs.push_back({name, log_cost});
  }
  for (ArmRatio& cost : costs) cost.ratio = std::exp(cost.ratio - least);
  std::sort(costs.begin(), costs.end(),
            [](const ArmRatio& a, const ArmRatio& b) { return a.ratio < b.ratio; });
  return costs;
}

std::string NameOf(const PriorsGroupKey& key) {
  std::string name = key.project + "/" + key.scene;
  if (!key.machine_class.empty()) name += " on " + key.machine_class;
  if (!key.build.empty()) name += " in build " + key.build;
  if (key.is_quarantined) name += " (in quarantine)";
  return name;
}

}  // namespace sweepstake::cli
