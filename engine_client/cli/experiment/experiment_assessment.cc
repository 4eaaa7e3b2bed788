#include "engine_client/cli/experiment/experiment_assessment.h"

#include <algorithm>
#include <thread>

#include "engine_client/cli/game/scene_choice.h"
#include "engine_client/cli/io/stop_signal.h"
#include "engine_client/cli/trace/cost_trace.h"
#include "engine_client/cli/trace/trace_run.h"

namespace sweepstake::cli {
namespace {

constexpr double kProgressSteps = 1000;  // per cell

uint64_t Steps(size_t cells, double share) {
  return static_cast<uint64_t>(kProgressSteps * (static_cast<double>(cells) + share));
}

// Of a trace that was made with other options nothing is known.
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

std::vector<const CellSummary*> CellsOf(const ExperimentReport& report,
                                        const ExperimentCell& cell) {
  std::vector<const CellSummary*> cells;
  for (const CellSummary& summary : report.cells) {
    if (summary.cell == cell) cells.push_back(&summary);
  }
  return cells;
}

}  // namespace

Status TraceCells(const ExperimentPlan& plan, const ExperimentFolder& folder, Terminal& terminal) {
  Progress progress(terminal, "trace", Steps(plan.cells.size(), 0));
  for (size_t i = 0; i < plan.cells.size() && !StopRequested(); ++i) {
    const ExperimentCell& cell = plan.cells[i];
    if (IsTraceOf(ReadCosts(folder.TraceFile(cell)), plan)) continue;
    const auto trace = RunTrace(
        OptionsOf(plan, cell), [&](double share) { progress.Show(Steps(i, share), cell.label()); });
    if (!trace.ok()) return trace.status();
    if (Status status = WriteCosts(folder.TraceFile(cell), *trace); !status.ok()) return status;
  }
  return {};
}

Status Assess(const ExperimentFolder& folder, Terminal& terminal, ExperimentReport& report) {
  TruthOptions options;
  options.seed_count = report.plan.options.replay_seed_count;
  options.thread_count = std::max(1U, std::thread::hardware_concurrency());
  options.time_scale = report.plan.options.time_scale;
  Progress progress(terminal, "replay", Steps(report.plan.cells.size(), 0));
  for (size_t i = 0; i < report.plan.cells.size(); ++i) {
    const ExperimentCell& cell = report.plan.cells[i];
    const auto trace = ReadCosts(folder.TraceFile(cell));
    if (!IsTraceOf(trace, report.plan)) continue;
    report.truths.push_back(RankArms(cell, *trace));
    if (StopRequested()) continue;
    const auto done = [&](double share) { progress.Show(Steps(i, share), cell.label()); };
    Status status = AssessCell(*trace, CellsOf(report, cell), options, done, report.truths.back());
    if (!status.ok()) return status;
  }
  report.over_cells = CompareOverCells(report.truths);
  report.over_live = CompareLive(report.truths);
  return {};
}

}  // namespace sweepstake::cli
