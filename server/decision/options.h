// Every number of the mechanism, with the paper's value as default (paper §4 and §6.3).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace sweepstake::decision {

// Weights of the reward's four scores; each finite and >= 0, sum 1 ± 1e-9 (paper §4).
struct RewardWeights {
  double fps = 0.55;
  double detection = 0.25;
  double memory = 0.12;
  double checks = 0.08;
};

struct DecisionOptions {
  std::string policy = "default";  // one of PolicyNames()
  RewardWeights weights;
  int64_t decision_interval_ns = 2'000'000'000;  // Δt, > 0
  int64_t cooldown_ns = 40'000'000'000;  // since the last executed switch of any reason, >= 0
  int64_t settling_ns = 2'000'000'000;   // of frame time after the first frame on the new arm, >= 0
  int64_t bail_out_ns =
      5'000'000'000;  // a longer frame is a bail-out, > 0; not divided by the time scale
  int64_t exploration_warm_up_ns = 2'000'000'000;  // per arm, >= 0
  int64_t exploration_measure_ns = 4'000'000'000;  // per arm, > 0
  bool explore = true;                             // false: no initial exploration
  double bail_out_penalty = 10;                    // zero-reward observations, >= 0
  double fps_floor = 30;  // below it even the best arm is a degraded scene, >= 0

  // Every interval but bail_out_ns divided by `time_scale`; one above 0 stays above 0. REQUIRES: 1
  // <= time_scale <= 1000.
  DecisionOptions Scaled(double time_scale) const;
};

// Bounds of what Validate lets through.
inline constexpr int64_t kLongestIntervalNs = 8'640'000'000'000'000;  // 100 days
inline constexpr double kLargestPenalty = 1e6;
inline constexpr double kLargestFpsFloor = 1000;

// Names of the policies; "default" stands for the one of "AI Decides".
std::span<const std::string_view> PolicyNames();

// What is wrong with the options and how to mend it, one line; absent when they are valid.
std::optional<std::string> Validate(const DecisionOptions& options);

}  // namespace sweepstake::decision
