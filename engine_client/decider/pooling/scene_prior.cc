#include "engine_client/decider/pooling/scene_prior.h"

#include <algorithm>

#include "engine_client/decider/policy/log_cost.h"

namespace sweepstake::decision {
namespace {

struct Moments {
  double count = 0;
  double sum = 0;
  double square_sum = 0;

  void Add(double value) {
    ++count;
    sum += value;
    square_sum += value * value;
  }
  double mean() const { return count > 0 ? sum / count : 0; }
  double variance() const { return count > 1 ? (square_sum - sum * mean()) / (count - 1) : 0; }
};

bool IsKnown(const EvidenceSum& arm) { return arm.evidence() > 0; }

double MeanOf(const EvidenceSum& sum) { return sum.alpha / sum.evidence(); }

EvidenceSum SumOf(double mean, double evidence) {
  return {.alpha = evidence * mean, .beta = evidence * (1 - mean)};
}

// Returns the mean difference between the rewards of windows and the rewards of visits, over the
// arms that have both.
double LevelOf(std::span<const ArmEvidence> arms) {
  Moments level;
  for (const ArmEvidence& arm : arms) {
    if (IsKnown(arm.live) && IsKnown(arm.lane) && arm.bail_out_count == 0)
      level.Add(MeanOf(arm.live) - MeanOf(arm.lane));
  }
  return level.mean();
}

EvidenceSum Pool(const ArmEvidence& arm, double level) {
  if (!IsKnown(arm.lane)) return arm.live;
  double mean = std::clamp(MeanOf(arm.lane) + level, 0.0, 1.0);
  if (arm.bail_out_count > 0) mean = std::min(mean, MeanOf(arm.live));
  const double of_visits = 1 / (1 / arm.lane.evidence() + 1 / EvidenceOf(mean, kLaneBiasVariance));
  return SumOf(mean, of_visits + arm.live.evidence());
}

// Means over the scenes that have evidence about several arms.
struct CommonRewards {
  Moments level;              // each scene's mean reward over its arms
  std::vector<Moments> arms;  // per arm: its reward relative to its scene's level
};

CommonRewards CommonOf(std::span<const std::vector<EvidenceSum>> scenes, size_t arm_count) {
  CommonRewards common{.level = {}, .arms = std::vector<Moments>(arm_count)};
  for (const std::vector<EvidenceSum>& scene : scenes) {
    Moments of_scene;
    for (const EvidenceSum& arm : scene) {
      if (IsKnown(arm)) of_scene.Add(MeanOf(arm));
    }
    if (of_scene.count < 2) continue;
    common.level.Add(of_scene.mean());
    for (size_t arm = 0; arm < arm_count; ++arm) {
      if (IsKnown(scene[arm])) common.arms[arm].Add(MeanOf(scene[arm]) - of_scene.mean());
    }
  }
  return common;
}

// Returns the level of the scene's own sums `own`. For each arm, it is the arm's mean reward minus
// its common relative reward (CommonRewards::arms); the result is the mean over the arms. Without
// own sums, returns the mean level of the other scenes.
double LevelOf(std::span<const EvidenceSum> own, const CommonRewards& common) {
  Moments level;
  for (size_t arm = 0; arm < own.size(); ++arm) {
    if (IsKnown(own[arm]) && common.arms[arm].count > 0)
      level.Add(MeanOf(own[arm]) - common.arms[arm].mean());
  }
  return level.count > 0 ? level.mean() : common.level.mean();
}

}  // namespace

ArmEvidence EvidenceBy(std::string_view measured_by, const Evidence& evidence) {
  const EvidenceSum sum = {evidence.alpha, evidence.beta};
  if (!measured_by.empty()) return {.lane = sum, .visit_count = evidence.window_count};
  return {.live = sum,
          .bail_out_count = evidence.bail_out_count,
          .window_count = evidence.window_count};
}

bool IsAnythingKnown(std::span<const EvidenceSum> arms) {
  return std::any_of(arms.begin(), arms.end(), IsKnown);
}

std::vector<EvidenceSum> WithOtherScenes(std::vector<EvidenceSum> own,
                                         std::span<const std::vector<EvidenceSum>> others) {
  const CommonRewards common = CommonOf(others, own.size());
  const double level = LevelOf(own, common);
  for (size_t arm = 0; arm < own.size(); ++arm) {
    const Moments& relative = common.arms[arm];
    if (IsKnown(own[arm]) || relative.count == 0) continue;
    const double mean = std::clamp(level + relative.mean(), 0.0, 1.0);
    const double spread = std::max(LogCostVarianceOf(relative.variance()), kTransferVariance);
    own[arm] = SumOf(mean, EvidenceOf(mean, spread * (1 + 1 / relative.count)));
  }
  return own;
}

std::vector<EvidenceSum> PoolEvidence(std::span<const ArmEvidence> arms) {
  const double level = LevelOf(arms);
  std::vector<EvidenceSum> pooled;
  for (const ArmEvidence& arm : arms) pooled.push_back(Pool(arm, level));
  return pooled;
}

}  // namespace sweepstake::decision
