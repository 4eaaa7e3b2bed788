#include "engine_client/decider/policy/reward.h"

#include <algorithm>
#include <cmath>

namespace sweepstake::decision {
namespace {

double ScoreBelow(double value, double limit) { return 1 - std::clamp(value / limit, 0.0, 1.0); }

}  // namespace

void FpsReference::Add(double fps) {
  fps_[next_] = fps;
  next_ = (next_ + 1) % kWindowCount;
  count_ = std::min(count_ + 1, kWindowCount);
}

double FpsReference::Quantile(double p) const {
  if (count_ == 0) return 0;
  std::array<double, kWindowCount> sorted = fps_;
  std::sort(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(count_));
  const double h = static_cast<double>(count_ - 1) * p;
  const size_t k = std::min(static_cast<size_t>(h), count_ - 1);
  const size_t above = std::min(k + 1, count_ - 1);
  return sorted[k] + (h - static_cast<double>(k)) * (sorted[above] - sorted[k]);
}

double FpsReference::Score(double fps) const {
  if (fps < kNearStallFps) return 0;
  const double high = std::max(Quantile(0.95), kMinHigh);
  const double low = std::min(Quantile(0.05), high / 2);
  return std::clamp((fps - low) / (high - low), 0.0, 1.0);
}

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
  const RewardWeights w = WeightsAt(weights, metrics.fps);
  const RewardScores s = Score(metrics, reference);
  const double reward =
      (w.fps * s.fps + w.detection * s.detection) + (w.memory * s.memory + w.checks * s.checks);
  if (!std::isfinite(reward)) return std::nullopt;
  return std::clamp(reward, 0.0, 1.0);
}

}  // namespace sweepstake::decision
