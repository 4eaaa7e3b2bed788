#include "server/decision/policy/reward.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace sweepstake::decision {
namespace {

double ScoreBelow(double value, double limit) { return 1 - std::clamp(value / limit, 0.0, 1.0); }

Eigen::Array4d ToArray(const RewardScores& s) { return {s.fps, s.detection, s.memory, s.checks}; }
Eigen::Array4d ToArray(const RewardWeights& w) { return {w.fps, w.detection, w.memory, w.checks}; }

}  // namespace

RewardScores Score(const WindowMetrics& metrics, const FpsReference& reference) {
  return {.fps = reference.Score(metrics.fps),
          .detection = ScoreBelow(metrics.detection_ms, kDetectionLimitMs),
          .memory = ScoreBelow(metrics.native_mib, kMemoryLimitMib),
          .checks = ScoreBelow(metrics.check_ratio, 1)};
}

RewardWeights WeightsAt(const RewardWeights& weights, double fps) {
  if (fps >= kLowFps || weights.fps >= kFpsWeightAtStall) return weights;
  const double shortfall = (kLowFps - std::max(fps, 0.0)) / kLowFps;
  const double raised = weights.fps + (kFpsWeightAtStall - weights.fps) * shortfall;
  const double rest = (1 - raised) / (1 - weights.fps);
  return {.fps = raised,
          .detection = weights.detection * rest,
          .memory = weights.memory * rest,
          .checks = weights.checks * rest};
}

std::optional<double> Reward(const WindowMetrics& metrics, const FpsReference& reference,
                             const RewardWeights& weights) {
  if (!metrics.IsFinite()) return std::nullopt;
  const Eigen::Array4d weighted =
      ToArray(WeightsAt(weights, metrics.fps)) * ToArray(Score(metrics, reference));
  const double reward = weighted.sum();
  if (!std::isfinite(reward)) return std::nullopt;
  return std::clamp(reward, 0.0, 1.0);
}

}  // namespace sweepstake::decision
