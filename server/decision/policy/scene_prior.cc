#include "server/decision/policy/scene_prior.h"

#include <algorithm>
#include <optional>

#include "server/decision/policy/log_cost.h"

namespace sweepstake::decision {
namespace {

constexpr double kMinSceneVariance = 0.3 * 0.3;  // of an arm's relative log-cost between scenes

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
  if (arm.bail_out_count > 0) mean = std::min(mean, MeanOf(arm.live));
  const double of_visits = 1 / (1 / arm.lane.evidence() + 1 / EvidenceOf(mean, kLaneBiasVariance));
  const double evidence = of_visits + arm.live.evidence();
  return {.alpha = evidence * mean, .beta = evidence * (1 - mean)};
}

// The rewards of an arm relative to the mean of a scene's arms, over scenes.
struct RelativeRewards {
  double count = 0;
  double sum = 0;
  double square_sum = 0;

  double mean() const { return sum / count; }
  double variance() const { return count > 1 ? (square_sum - sum * mean()) / (count - 1) : 0; }
};

// Returns the mean over the arms that have evidence, or nothing if there are none to compare.
std::optional<double> SceneMean(std::span<const EvidenceSum> arms) {
  double sum = 0;
  double count = 0;
  for (const EvidenceSum& arm : arms) {
    if (!(arm.evidence() > 0)) continue;
    sum += MeanOf(arm);
    ++count;
  }
  return count > 1 ? std::optional(sum / count) : std::nullopt;
}

}  // namespace

bool IsAnythingKnown(std::span<const EvidenceSum> arms) {
  return std::any_of(arms.begin(), arms.end(), [](const auto& arm) { return arm.evidence() > 0; });
}

std::vector<EvidenceSum> PriorOfNewScene(std::span<const std::vector<EvidenceSum>> scenes) {
  std::vector<RelativeRewards> arms(scenes.empty() ? 0 : scenes.front().size());
  double level = 0;
  double count = 0;
  for (const std::vector<EvidenceSum>& scene : scenes) {
    const std::optional<double> mean = SceneMean(scene);
    if (!mean) continue;
    level += (*mean - level) / ++count;
    for (size_t arm = 0; arm < scene.size(); ++arm) {
      if (!(scene[arm].evidence() > 0)) continue;
      const double relative = MeanOf(scene[arm]) - *mean;
      ++arms[arm].count;
      arms[arm].sum += relative;
      arms[arm].square_sum += relative * relative;
    }
  }
  std::vector<EvidenceSum> prior;
  for (const RelativeRewards& arm : arms) {
    EvidenceSum& sum = prior.emplace_back();
    if (arm.count == 0) continue;
    const double mean = std::clamp(level + arm.mean(), 0.0, 1.0);
    const double spread = std::max(LogCostVarianceOf(arm.variance()), kMinSceneVariance);
    const double evidence = EvidenceOf(mean, spread * (1 + 1 / arm.count));
    sum = {.alpha = evidence * mean, .beta = evidence * (1 - mean)};
  }
  return prior;
}

std::vector<EvidenceSum> WithOtherScenes(std::vector<EvidenceSum> own,
                                         std::span<const std::vector<EvidenceSum>> others) {
  const std::vector<EvidenceSum> prior = PriorOfNewScene(others);
  if (prior.empty()) return own;
  double level = 0;
  double count = 0;
  for (size_t arm = 0; arm < own.size(); ++arm) {
    if (!(own[arm].evidence() > 0) || !(prior[arm].evidence() > 0)) continue;
    level += (MeanOf(own[arm]) - MeanOf(prior[arm]) - level) / ++count;
  }
  for (size_t arm = 0; arm < own.size(); ++arm) {
    if (own[arm].evidence() > 0 || !(prior[arm].evidence() > 0)) continue;
    const double mean = std::clamp(MeanOf(prior[arm]) + level, 0.0, 1.0);
    const double evidence = prior[arm].evidence();
    own[arm] = {.alpha = evidence * mean, .beta = evidence * (1 - mean)};
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
