#include "tests/laboratory/trace/trace_summary.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/statistics.h"
#include "engine_client/cli/io/text_table.h"

namespace sweepstake::cli {
namespace {

Json ArmJson(const TracedArm& arm, const TracedArmSummary& summary) {
  return {{"arm", arm.name},
          {"version", arm.version},
          {"ms_mean", summary.ms_mean},
          {"ms_median", summary.ms_median},
          {"ms_p99", summary.ms_p99},
          {"build_ms_median", summary.build_ms},
          {"best_share", summary.best_ratio},
          {"held_share", summary.held_ratio}};
}

Json ControlJson(const CostTrace& trace, const TraceSummary& summary) {
  const bool has_interval = summary.control_low < summary.control_high;
  return {{"arm", trace.arms[trace.control_arm].name},
          {"ratio", summary.control_ratio},
          {"ci95", has_interval ? Json{summary.control_low, summary.control_high} : Json(nullptr)},
          {"fair", summary.ControlIsFair()}};
}

std::string ObjectCounts(const TraceSummary& summary) {
  const std::string max = std::to_string(summary.object_count_max);
  return summary.object_count_min == summary.object_count_max
             ? max
             : std::to_string(summary.object_count_min) + " to " + max;
}

constexpr double kMsPerNs = 1e-6;

std::vector<double> TimesOf(const CostTrace& trace, uint32_t arm) {
  std::vector<double> times;
  for (uint32_t frame = 0; frame < trace.frame_count; ++frame) {
    times.push_back(kMsPerNs * static_cast<double>(trace.detection(frame, arm)));
  }
  return times;
}

double MedianBuild(const CostTrace& trace, uint32_t arm) {
  std::vector<double> builds;
  for (const TraceBurst& burst : trace.bursts) {
    builds.push_back(
        kMsPerNs * static_cast<double>(burst.detection_ns[size_t{arm} * trace.burst_frame_count]));
  }
  return Median(std::move(builds));
}

double HeldRatio(const CostTrace& trace, uint32_t arm) {
  uint32_t held = 0;
  for (uint32_t frame = 0; frame < trace.frame_count; ++frame) {
    held += trace.held[frame * trace.arms.size() + arm];
  }
  return static_cast<double>(held) / trace.frame_count;
}

TracedArmSummary SummarizeArm(const CostTrace& trace, uint32_t arm) {
  TracedArmSummary summary{Summarize(TimesOf(trace, arm))};
  summary.held_ratio = HeldRatio(trace, arm);
  summary.build_ms = MedianBuild(trace, arm);
  return summary;
}

// Returns sums over windows of kWindowFrames frames; the last window may be shorter.
template <typename ValueOf>
std::vector<double> WindowSums(uint32_t frame_count, const ValueOf& value_of) {
  std::vector<double> sums((frame_count + TraceSummary::kWindowFrames - 1) /
                           TraceSummary::kWindowFrames);
  for (uint32_t frame = 0; frame < frame_count; ++frame) {
    sums[frame / TraceSummary::kWindowFrames] += static_cast<double>(value_of(frame));
  }
  return sums;
}

double Total(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

// Computes the time of the A/A control (a second structure of control_arm) ÷ the time of
// control_arm, and the 95 % interval of this ratio. The standard error is computed by linearization
// (W. Cochran, Sampling Techniques, §6.3).
void SummarizeControl(const CostTrace& trace, TraceSummary& summary) {
  const auto control =
      WindowSums(trace.frame_count, [&](uint32_t frame) { return trace.control_ns[frame]; });
  const auto twin = WindowSums(
      trace.frame_count, [&](uint32_t frame) { return trace.detection(frame, trace.control_arm); });
  const double ratio = Total(control) / Total(twin);
  double square_sum = 0;
  for (size_t i = 0; i < control.size(); ++i) {
    const double residual = control[i] - ratio * twin[i];
    square_sum += residual * residual;
  }
  const auto count = static_cast<double>(control.size());
  const double error = count < 2 ? 0 : std::sqrt(square_sum * count / (count - 1)) / Total(twin);
  constexpr double kNormal95 = 1.96;
  summary.control_ratio = ratio;
  summary.control_low = ratio - kNormal95 * error;
  summary.control_high = ratio + kNormal95 * error;
}

// Counts for each arm the windows in which it is the cheapest. Returns the total time of the
// oracle, which runs the cheapest arm of each window.
double SummarizeWindows(const CostTrace& trace, TraceSummary& summary) {
  std::vector<std::vector<double>> sums;
  for (uint32_t arm = 0; arm < trace.arm_count(); ++arm) {
    sums.push_back(
        WindowSums(trace.frame_count, [&](uint32_t frame) { return trace.detection(frame, arm); }));
  }
  const size_t window_count = sums.front().size();
  double oracle_ns = 0;
  for (size_t window = 0; window < window_count; ++window) {
    size_t best = 0;
    for (size_t arm = 1; arm < sums.size(); ++arm) {
      if (sums[arm][window] < sums[best][window]) best = arm;
    }
    summary.arms[best].best_ratio += 1.0 / static_cast<double>(window_count);
    oracle_ns += sums[best][window];
  }
  return oracle_ns;
}

double FrameOracleNs(const CostTrace& trace) {
  double oracle_ns = 0;
  const auto arm_count = static_cast<ptrdiff_t>(trace.arms.size());
  for (auto frame = trace.detection_ns.begin(); frame != trace.detection_ns.end();
       frame += arm_count) {
    oracle_ns += static_cast<double>(*std::min_element(frame, frame + arm_count));
  }
  return oracle_ns;
}

}  // namespace

TraceSummary SummarizeTrace(const CostTrace& trace) {
  TraceSummary summary;
  for (uint32_t arm = 0; arm < trace.arm_count(); ++arm) {
    summary.arms.push_back(SummarizeArm(trace, arm));
    if (summary.arms[arm].ms_mean < summary.arms[summary.best_arm].ms_mean) summary.best_arm = arm;
  }
  const auto [min, max] = std::minmax_element(trace.object_count.begin(), trace.object_count.end());
  summary.object_count_min = *min;
  summary.object_count_max = *max;
  summary.pair_count_mean =
      std::accumulate(trace.pair_count.begin(), trace.pair_count.end(), 0.0) / trace.frame_count;
  SummarizeControl(trace, summary);
  const double best_ns = summary.arms[summary.best_arm].ms_mean / kMsPerNs * trace.frame_count;
  // Rounding could make these values negative.
  summary.window_headroom = std::max(0.0, 1 - SummarizeWindows(trace, summary) / best_ns);
  summary.frame_headroom = std::max(0.0, 1 - FrameOracleNs(trace) / best_ns);
  return summary;
}

Json TraceJson(const CostTrace& trace, const TraceSummary& summary, const std::string& file) {
  Json arms = Json::array();
  for (size_t i = 0; i < trace.arms.size(); ++i) {
    arms.push_back(ArmJson(trace.arms[i], summary.arms[i]));
  }
  return {{"scene", trace.scene},
          {"objects", summary.object_count_max},
          {"objects_min", summary.object_count_min},
          {"seed", trace.seed},
          {"frames", trace.frame_count},
          {"repeats", trace.repeat_count},
          {"machine", trace.machine},
          {"file", file},
          {"pairs_mean", summary.pair_count_mean},
          {"bursts", trace.bursts.size()},
          {"burst_frames", trace.burst_frame_count},
          {"descriptors", trace.descriptors.size()},
          {"arms", std::move(arms)},
          {"best_arm", trace.arms[summary.best_arm].name},
          {"headroom_by_frame", summary.frame_headroom},
          {"headroom_by_window", summary.window_headroom},
          {"window_frames", TraceSummary::kWindowFrames},
          {"control", ControlJson(trace, summary)}};
}

void PrintTrace(const CostTrace& trace, const TraceSummary& summary, const std::string& file,
                std::ostream& out) {
  out << file << ": " << trace.scene << ", " << ObjectCounts(summary) << " objects, seed "
      << trace.seed << ", " << trace.frame_count << " frames, " << trace.bursts.size()
      << " bursts\n";
  TextTable table({"arm", "ms_mean", "ms_median", "ms_p99", "build_ms", "best", "held"});
  for (size_t i = 0; i < trace.arms.size(); ++i) {
    const TracedArmSummary& arm = summary.arms[i];
    table.AddRow({trace.arms[i].name, Fixed(arm.ms_mean, 4), Fixed(arm.ms_median, 4),
                  Fixed(arm.ms_p99, 4), Fixed(arm.build_ms, 4), Percent(arm.best_ratio, 1),
                  Percent(arm.held_ratio, 1)});
  }
  table.Print(out);
  out << "Best fixed arm: " << trace.arms[summary.best_arm].name
      << ".\nThe cheapest arm of every frame would save " << Percent(summary.frame_headroom, 1)
      << " of its time,\nthe cheapest arm of every " << TraceSummary::kWindowFrames << " frames "
      << Percent(summary.window_headroom, 1) << ".\nA/A control, which shows the noise:\na second "
      << trace.arms[trace.control_arm].name << " takes " << Fixed(summary.control_ratio, 4)
      << " times as long as the first one\n(95 % interval: " << Fixed(summary.control_low, 4)
      << " to " << Fixed(summary.control_high, 4) << ").\n";
}

void PrintControlWarning(const CostTrace& trace, const TraceSummary& summary, std::ostream& err) {
  if (summary.ControlIsFair()) return;
  err << "Warning: " << trace.scene << ": two structures of " << trace.arms[trace.control_arm].name
      << " differ by " << Percent(summary.control_ratio - 1, 2)
      << ", more than 0.5 %: keep the machine free of other work, or use more --repeats or "
         "--frames\n";
}

}  // namespace sweepstake::cli
