// Summarizes a cost trace in a few numbers, and shows it as text and JSON. Times are in
// milliseconds.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <ostream>
#include <string>
#include <vector>

#include "engine_client/cli/io/statistics.h"
#include "tests/laboratory/trace/cost_trace.h"

namespace sweepstake::cli {

struct TracedArmSummary : TimeSummary {
  double best_ratio = 0;  // share of the windows in which this arm is the cheapest
  double held_ratio = 0;  // share of the frames in which this arm was not measured
  double build_ms = 0;    // a fresh structure's first frame, median over the bursts
};

struct TraceSummary {
  // Length of a window. The cheapest arm is determined per window, because noise too often decides
  // which arm is the cheapest in a single frame.
  static constexpr uint32_t kWindowFrames = 20;
  // The maximum difference of the control ratio from 1. If it is larger, the arms were not measured
  // under equal conditions.
  static constexpr double kFairWithin = 0.005;

  std::vector<TracedArmSummary> arms;
  size_t best_arm = 0;  // the best fixed arm, which has the minimum total time
  uint32_t object_count_min = 0;
  uint32_t object_count_max = 0;
  double pair_count_mean = 0;
  // Total time of the A/A control ÷ total time of its arm, with the 95 % interval of this ratio.
  // The standard error comes from the spread between windows. With fewer than two windows the
  // interval has no width.
  double control_ratio = 1;
  double control_low = 1;
  double control_high = 1;
  // 1 − total time of the oracle ÷ total time of the best fixed arm. The oracle runs the cheapest
  // arm of each frame, or of each window.
  double frame_headroom = 0;
  double window_headroom = 0;

  bool ControlIsFair() const {
    return control_ratio > 1 - kFairWithin && control_ratio < 1 + kFairWithin;
  }
};

// REQUIRES: ErrorOf(trace).empty().
TraceSummary SummarizeTrace(const CostTrace& trace);

// Returns a row of the command's --json; `file` is the path of the trace.
nlohmann::ordered_json TraceJson(const CostTrace& trace, const TraceSummary& summary,
                                 const std::string& file);

// Prints a table of the arms and a few lines about the whole trace.
void PrintTrace(const CostTrace& trace, const TraceSummary& summary, const std::string& file,
                std::ostream& out);

// Prints a warning if the control ratio differs from 1 by more than kFairWithin.
void PrintControlWarning(const CostTrace& trace, const TraceSummary& summary, std::ostream& err);

}  // namespace sweepstake::cli
