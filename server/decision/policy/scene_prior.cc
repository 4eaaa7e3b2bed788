#include "server/decision/policy/scene_prior.h"

#include <algorithm>

#include "server/decision/policy/log_cost.h"

namespace sweepstake::decision {
namespace {

double MeanOf(const EvidenceSum& sum) { return sum.alpha / sum.evidence(); }

bool HasBoth(const ArmEvidence& arm) {
  return arm.live.evidence() > 0 && arm.lane.evidence() > 0 && arm.bail_out_count == 0;
}

// By how much the windows' mean rewards exceed those of the visits.
double LevelOf(std::span<const ArmEvidence> arms) {
  double sum = 0;
  double count = 0;
  for (const ArmEvidence& arm : arms) {
    if (!HasBoth(arm)) continue;
    sum += MeanOf(arm.live) - MeanOf(arm.lane);
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

EvidenceSum Pool(const ArmEvidence& arm, double level) {
  if (!(arm.lane.evidence() > 0)) return arm.live;
  double mean = std::clamp(MeanOf(arm.lane) + level, 0.0, 1.0);
  double evidence = arm.lane.evidence() + arm.live.evidence();
  if (arm.bail_out_count > 0) mean = std::min(mean, MeanOf(arm.live));
  if (!(arm.live.evidence() > 0))
    evidence = 1 / (1 / evidence + 1 / EvidenceOf(mean, kLaneBiasVariance));
  return {.alpha = evidence * mean, .beta = evidence * (1 - mean)};
}

}  // namespace

std::vector<EvidenceSum> PoolEvidence(std::span<const ArmEvidence> arms) {
  const double level = LevelOf(arms);
  std::vector<EvidenceSum> pooled;
  for (const ArmEvidence& arm : arms) pooled.push_back(Pool(arm, level));
  return pooled;
}

}  // namespace sweepstake::decision
