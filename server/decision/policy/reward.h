// A window's metrics to one number in [0, 1] (paper §4 and §6.3). Pure functions.
#pragma once

#include <optional>

#include "server/decision/options.h"
#include "server/decision/policy/fps_reference.h"
#include "server/decision/window.h"

namespace sweepstake::decision {

// One score per metric, each in [0, 1], 1 is best.
struct RewardScores {
  double fps = 0;
  double detection = 0;  // 1 − clamp(DET / 16.67 ms)
  double memory = 0;     // 1 − clamp(MEM / 64 MiB)
  double checks = 0;     // 1 − clamp(CHK / (n(n−1)/2))
};

inline constexpr double kDetectionLimitMs = 16.67;
inline constexpr double kMemoryLimitMib = 64;
inline constexpr double kLowFps = 25;
inline constexpr double kFpsWeightAtStall = 0.85;

// REQUIRES: metrics.IsFinite().
RewardScores Score(const WindowMetrics& metrics, const FpsReference& reference);

// The weights at this frame rate: under 25 FPS the FPS weight rises linearly, to 0.85 at 0 FPS, and
// the others shrink in proportion, so that the sum stays. A configured FPS weight above 0.85 stays
// as it is.
RewardWeights WeightsAt(const RewardWeights& weights, double fps);

// Σ weight × score, clamped to [0, 1]; absent where a metric is not finite.
std::optional<double> Reward(const WindowMetrics& metrics, const FpsReference& reference,
                             const RewardWeights& weights);

}  // namespace sweepstake::decision
