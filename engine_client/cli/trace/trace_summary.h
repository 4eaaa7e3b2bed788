// What a cost trace says in a few numbers. Pure functions, safe from any thread. Milliseconds.
#pragma once

#include <cstdint>
#include <vector>

#include "engine_client/cli/trace/cost_trace.h"

namespace sweepstake::cli {

struct TracedArmSummary {
  double ms_mean = 0;
  double ms_median = 0;
  double ms_p99 = 0;
  double best_ratio = 0;  // share of the windows in which it is the cheapest
  double held_ratio = 0;  // share of the frames in which it was not measured
  double build_ms = 0;    // median over the bursts: a fresh structure's first frame
};

struct TraceSummary {
  // The cheapest arm is that of a window: in a single frame it is too often a matter of luck.
  static constexpr uint32_t kWindowFrames = 20;
  // A control that differs by more than this shows that the arms were not measured alike.
  static constexpr double kFairWithin = 0.005;

  std::vector<TracedArmSummary> arms;
  size_t best_arm = 0;  // with the minimum total time: the best fixed arm
  uint32_t object_count_min = 0;
  uint32_t object_count_max = 0;
  double pair_count_mean = 0;
  // Total time of the control ÷ that of its twin, and the 95 % interval of the ratio, whose
  // standard error comes from the spread between windows; without two windows it has no width.
  double control_ratio = 1;
  double control_low = 1;
  double control_high = 1;
  // Total time of the best fixed arm ÷ that of the oracle, minus 1: the oracle takes the cheapest
  // arm of every frame, or of every window.
  double frame_headroom = 0;
  double window_headroom = 0;

  bool ControlIsFair() const {
    return control_ratio > 1 - kFairWithin && control_ratio < 1 + kFairWithin;
  }
};

// REQUIRES: FlawOf(trace).empty().
TraceSummary SummarizeTrace(const CostTrace& trace);

}  // namespace sweepstake::cli
