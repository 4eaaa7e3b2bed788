#include "tests/laboratory/trace/trace_output.h"

#include <nlohmann/json.hpp>

#include "engine_client/cli/io/csv_file.h"
#include "engine_client/cli/io/text_table.h"

namespace sweepstake::cli {
namespace {

using Json = nlohmann::ordered_json;

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

void WriteRow(uint32_t frame, const std::string& arm, const CostTrace& trace, uint64_t ns,
              std::string_view checks, std::string_view bytes, std::string_view held,
              CsvFile& csv) {
  csv.Row({std::to_string(frame), arm, std::to_string(trace.object_count[frame]),
           std::to_string(trace.pair_count[frame]), Fixed(static_cast<double>(ns) * 1e-6, 6),
           checks, bytes, held});
}

}  // namespace

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
      << " of it,\nof every " << TraceSummary::kWindowFrames << " frames "
      << Percent(summary.window_headroom, 1) << ".\nA/A control: a second "
      << trace.arms[trace.control_arm].name << " takes " << Fixed(summary.control_ratio, 4)
      << " of the first one's time\n(95 %: " << Fixed(summary.control_low, 4) << " to "
      << Fixed(summary.control_high, 4) << ").\n";
}

void PrintControlWarning(const CostTrace& trace, const TraceSummary& summary, std::ostream& err) {
  if (summary.ControlIsFair()) return;
  err << "Warning: " << trace.scene << ": two structures of " << trace.arms[trace.control_arm].name
      << " differ by " << Percent(summary.control_ratio - 1, 2)
      << ", more than 0.5 %: keep the machine free of other work, or take more --repeats or "
         "--frames\n";
}

Status WriteTraceCsv(const CostTrace& trace, const std::filesystem::path& path) {
  auto csv = CsvFile::Create(
      path, {"frame", "arm", "objects", "pairs", "detection_ms", "aabb_checks", "bytes", "held"});
  if (!csv.ok()) return csv.status();
  for (uint32_t frame = 0; frame < trace.frame_count; ++frame) {
    for (uint32_t arm = 0; arm < trace.arm_count(); ++arm) {
      const size_t at = size_t{frame} * trace.arm_count() + arm;
      WriteRow(frame, trace.arms[arm].name, trace, trace.detection_ns[at],
               std::to_string(trace.aabb_check_count[at]), std::to_string(trace.native_bytes[at]),
               trace.held[at] == 0 ? "0" : "1", **csv);
    }
    WriteRow(frame, trace.arms[trace.control_arm].name + " control", trace, trace.control_ns[frame],
             "", "", "0", **csv);
  }
  return (*csv)->Commit();
}

}  // namespace sweepstake::cli
