// Reward version 1: a window's metrics as one number in [0, 1] (paper §4 and §6.3).
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "engine_client/decider/options.h"
#include "engine_client/decider/window.h"

namespace sweepstake::decision {

// The frame rates of the recent windows, with which a window's frame rate is compared: the paper's
// adaptive FPS normalisation (§4). The paper leaves some numbers open; they are fixed here.
//
// The range covers the last 30 windows of the run, over all arms, including the window being
// judged. Memory is fixed.
//
// The paper says "After each switch, it resets metric histories and counters" (§4). Here, the reset
// histories are the frames of the current window (session/arm_runs.h). The range is kept, because
// the paper calls it the range "observed in the current run", and a run has many switches. If it
// were reset too, each arm would only be compared with itself: an arm that runs steadily at 30 FPS
// or more would score 1 whatever its frame rate.
class FpsReference {
 public:
  static constexpr size_t kWindowCount = 30;
  static constexpr double kNearStallFps = 5;
  static constexpr double kMinHigh = 30;

  // Adds a window's frame rate and drops the oldest one if there are kWindowCount. REQUIRES: fps is
  // finite and >= 0.
  void Add(double fps);

  // Returns quantile p in [0, 1] of the kept windows, by linear interpolation (type 7 of Hyndman
  // and Fan): with the m values in ascending order x₀ … x₍ₘ₋₁₎, h = (m − 1)p and k = ⌊h⌋, it is
  // xₖ + (h − k)(xₖ₊₁ − xₖ). Returns 0 if no window is kept.
  double Quantile(double p) const;

  // Returns clamp((fps − lo) / (hi − lo), 0, 1) with hi = max(Q95, 30) and lo = min(Q05, hi/2), and
  // 0 below 5 FPS.
  double Score(double fps) const;

 private:
  std::array<double, kWindowCount> fps_{};
  size_t count_ = 0;
  size_t next_ = 0;
};

// One score per metric, each in [0, 1]; 1 is the best. DET, MEM and CHK are the paper's names of
// detection time, memory and AABB checks.
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

// Returns the weights at this frame rate. Under 25 FPS the FPS weight rises linearly, to 0.85 at
// 0 FPS, and the others shrink in proportion, so that the sum stays the same. A configured FPS
// weight above 0.85 is not changed.
RewardWeights WeightsAt(const RewardWeights& weights, double fps);

// Returns Σ weight × score, clamped to [0, 1], or nothing if a metric is not finite.
std::optional<double> Reward(const WindowMetrics& metrics, const FpsReference& reference,
                             const RewardWeights& weights);

}  // namespace sweepstake::decision
