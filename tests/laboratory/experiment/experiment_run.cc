#include "tests/laboratory/experiment/experiment_run.h"

#include <algorithm>
#include <string>
#include <thread>
#include <vector>

#include "engine_client/cli/game/scene_choice.h"
#include "engine_client/cli/io/stop_signal.h"
#include "sweepstake/adaptive_broad_phase.h"
#include "tests/laboratory/experiment/experiment_live.h"
#include "tests/laboratory/trace/cost_trace.h"
#include "tests/laboratory/trace/trace_run.h"

namespace sweepstake::cli {
namespace {

constexpr uint64_t kSecondNs = 1'000'000'000;

// Returns the finished share of all cells after `cells` cells and `share` of the next one.
double Share(const ExperimentPlan& plan, size_t cells, double share) {
  return (static_cast<double>(cells) + share) / static_cast<double>(plan.cells.size());
}

// Returns whether the trace was made with this experiment's options. If not, the scene is traced
// again.
bool IsTraceOf(const Result<CostTrace>& trace, const ExperimentPlan& plan) {
  return trace.ok() && trace->frame_count == plan.options.trace_frame_count;
}

TraceOptions OptionsOf(const ExperimentPlan& plan, const ExperimentCell& cell) {
  TraceOptions options;
  options.scene = {cell.scene, cell.object_count, cell.scene_seed};
  options.arms = *ChooseArms({"all"});
  options.frame_count = plan.options.trace_frame_count;
  return options;
}

std::vector<const CellSummary*> CellsOf(std::span<const CellSummary> summaries,
                                        const ExperimentCell& cell) {
  std::vector<const CellSummary*> cells;
  for (const CellSummary& summary : summaries) {
    if (summary.cell == cell) cells.push_back(&summary);
  }
  return cells;
}

class Grid {
 public:
  Grid(const ExperimentPlan& plan, const ExperimentFolder& folder,
       const ExperimentProgress& on_progress)
      : plan_(plan),
        folder_(folder),
        run_ns_(plan.expected_run_ns()),
        missing_(Missing()),
        start_ns_(SteadyClock().NowNs()),
        on_progress_(on_progress) {}

  Status Play() {
    for (const PlannedRun* run : missing_) {
      if (Status status = PlayOne(*run); !status.ok()) return status;
      if (StopRequested()) return {};
      ++done_count_;
    }
    return {};
  }

 private:
  std::vector<const PlannedRun*> Missing() const {
    std::vector<const PlannedRun*> missing;
    const std::vector<RunRecord> there = folder_.ReadRecords(plan_);
    for (const PlannedRun& run : plan_.runs) {
      const bool is_there = std::any_of(there.begin(), there.end(), [&](const RunRecord& record) {
        return RunLabel(record) == run.label();
      });
      if (!is_there) missing.push_back(&run);
    }
    return missing;
  }

  Status PlayOne(const PlannedRun& run) {
    LiveOptions options;
    options.window_ns = plan_.window_ns;
    options.time_scale = plan_.options.time_scale;
    if (plan_.options.frames) options.frames_file = folder_.FramesFile(run);
    options.go_on = [&](uint64_t elapsed_ns) {
      ReportProgress(run, elapsed_ns);
      return !StopRequested();
    };
    const auto record = PlayLive(run, options);
    if (!record.ok()) return record.status();
    return *record ? WriteRecord(**record, folder_.RunFile(run)) : Status();
  }

  // The remaining time is estimated from the finished runs, if there are any.
  void ReportProgress(const PlannedRun& run, uint64_t elapsed_ns) {
    const uint64_t done_ns = done_count_ * run_ns_ + std::min(elapsed_ns, run_ns_);
    const uint64_t total_ns = missing_.size() * run_ns_;
    const double pace = done_count_ == 0 ? 1.0
                                         : static_cast<double>(SteadyClock().NowNs() - start_ns_) /
                                               static_cast<double>(done_ns);
    const auto left_ns = static_cast<uint64_t>(pace * static_cast<double>(total_ns - done_ns));
    on_progress_(static_cast<double>(done_ns) / static_cast<double>(total_ns),
                 DurationText(left_ns) + " left; run " + std::to_string(done_count_ + 1) + " of " +
                     std::to_string(missing_.size()) + ": " + run.label());
  }

  const ExperimentPlan& plan_;
  const ExperimentFolder& folder_;
  const uint64_t run_ns_;
  const std::vector<const PlannedRun*> missing_;
  const uint64_t start_ns_;
  uint64_t done_count_ = 0;
  const ExperimentProgress& on_progress_;
};

}  // namespace

std::string DurationText(uint64_t ns) {
  const uint64_t seconds = (ns + kSecondNs / 2) / kSecondNs;
  if (seconds < 90) return std::to_string(seconds) + " s";
  const uint64_t minutes = (seconds + 30) / 60;
  if (minutes < 90) return std::to_string(minutes) + " min";
  return std::to_string(minutes / 60) + " h " + std::to_string(minutes % 60) + " min";
}

Status TraceCells(const ExperimentPlan& plan, const ExperimentFolder& folder,
                  const ExperimentProgress& on_progress) {
  for (size_t i = 0; i < plan.cells.size() && !StopRequested(); ++i) {
    const ExperimentCell& cell = plan.cells[i];
    if (IsTraceOf(ReadCosts(folder.TraceFile(cell)), plan)) continue;
    const auto trace = RunTrace(OptionsOf(plan, cell), [&](double share) {
      on_progress(Share(plan, i, share), cell.label());
    });
    if (!trace.ok()) return trace.status();
    if (Status status = WriteCosts(folder.TraceFile(cell), *trace); !status.ok()) return status;
  }
  return {};
}

Status PlayGrid(const ExperimentPlan& plan, const ExperimentFolder& folder,
                const ExperimentProgress& on_progress) {
  return Grid(plan, folder, on_progress).Play();
}

Result<ExperimentTruths> Assess(const ExperimentPlan& plan, const ExperimentFolder& folder,
                                std::span<const CellSummary> cells,
                                const ExperimentProgress& on_progress) {
  TruthOptions options;
  options.seed_count = plan.options.replay_seed_count;
  options.thread_count = std::max(1U, std::thread::hardware_concurrency());
  options.time_scale = plan.options.time_scale;
  ExperimentTruths truths;
  for (size_t i = 0; i < plan.cells.size(); ++i) {
    const ExperimentCell& cell = plan.cells[i];
    const auto trace = ReadCosts(folder.TraceFile(cell));
    if (!IsTraceOf(trace, plan)) continue;
    truths.cells.push_back(RankArms(cell, *trace));
    if (StopRequested()) continue;
    const auto done = [&](double share) { on_progress(Share(plan, i, share), cell.label()); };
    Status status = AssessCell(*trace, CellsOf(cells, cell), options, done, truths.cells.back());
    if (!status.ok()) return status;
  }
  truths.over_cells = CompareOverCells(truths.cells);
  truths.over_live = CompareLive(truths.cells);
  return truths;
}

}  // namespace sweepstake::cli
