#include "tests/laboratory/trace/trace_run.h"

#include <algorithm>
#include <filesystem>
#include <memory>

#include "sweepstake/machine_class.h"
#include "tests/laboratory/trace/trace_pass.h"

namespace sweepstake::cli {
namespace {

// Returns the lower quartile: the second of five values, the minimum of four or fewer.
uint64_t LowerQuartile(std::vector<uint64_t>& values) {
  const auto quartile = values.begin() + static_cast<ptrdiff_t>((values.size() - 1) / 4);
  std::nth_element(values.begin(), quartile, values.end());
  return *quartile;
}

// Replaces a column of the first run by the quartiles over all runs. `column` returns the column of
// a run.
void TakeQuartiles(std::vector<CostTrace>& runs,
                   const std::function<std::vector<uint64_t>&(CostTrace&)>& column) {
  std::vector<std::vector<uint64_t>*> columns;
  columns.reserve(runs.size());
  for (CostTrace& run : runs) columns.push_back(&column(run));
  std::vector<uint64_t> values(runs.size());
  for (size_t i = 0; i < columns.front()->size(); ++i) {
    for (size_t run = 0; run < columns.size(); ++run) values[run] = (*columns[run])[i];
    (*columns.front())[i] = LowerQuartile(values);
  }
}

void KeepHeldInAll(std::vector<CostTrace>& runs) {
  std::vector<uint8_t>& held = runs.front().held;
  for (const CostTrace& run : runs) {
    for (size_t i = 0; i < held.size(); ++i) held[i] = held[i] & run.held[i];
  }
}

Status TooManyObjects() {
  return {StatusCode::kInvalidArgument,
          "a trace takes up to " + std::to_string(kMaxTracedObjects) + " objects per frame"};
}

// Opens the scene at its start. Error: it has too many objects.
Result<std::unique_ptr<Scene>> Open(const SceneChoice& choice) {
  auto scene = OpenScene(choice);
  if (scene.ok() && (*scene)->aabbs().size() > kMaxTracedObjects) return TooManyObjects();
  return scene;
}

// Returns the plan of every run, except order_seed.
Result<TracePlan> MakePlan(const TraceOptions& options) {
  auto scene = Open(options.scene);
  if (!scene.ok()) return scene.status();
  TracePlan plan;
  plan.arms = options.arms;
  plan.frame_count = options.frame_count;
  plan.frame_ns = ProbeArms(plan.arms, **scene);
  const auto cheapest = std::min_element(plan.frame_ns.begin(), plan.frame_ns.end());
  plan.control_arm = static_cast<uint32_t>(cheapest - plan.frame_ns.begin());
  return plan;
}

Result<CostTrace> RunOnce(const TraceOptions& options, const TracePlan& plan,
                          const std::function<void(uint32_t)>& on_frame) {
  auto scene = Open(options.scene);
  if (!scene.ok()) return scene.status();
  auto trace = RunTracePass(**scene, plan, on_frame);
  // A recorded scene may have too many objects in later frames only.
  if (trace.ok() && trace->bursts.empty()) return TooManyObjects();
  return trace;
}

}  // namespace

CostTrace MergeRuns(std::vector<CostTrace> runs) {
  TakeQuartiles(
      runs, [](CostTrace & run) -> auto& { return run.step_ns; });
  TakeQuartiles(
      runs, [](CostTrace & run) -> auto& { return run.control_ns; });
  TakeQuartiles(
      runs, [](CostTrace & run) -> auto& { return run.detection_ns; });
  for (size_t i = 0; i < runs.front().bursts.size(); ++i) {
    TakeQuartiles(
        runs, [i](CostTrace & run) -> auto& { return run.bursts[i].detection_ns; });
  }
  KeepHeldInAll(runs);
  return std::move(runs.front());
}

Result<CostTrace> RunTrace(const TraceOptions& options,
                           const std::function<void(double)>& on_progress) {
  auto plan = MakePlan(options);
  if (!plan.ok()) return plan.status();
  std::vector<CostTrace> runs;
  const double all = static_cast<double>(options.frame_count) * options.repeat_count;
  while (runs.size() < options.repeat_count) {
    plan->order_seed = options.scene.seed * options.repeat_count + runs.size();
    const double before =
        static_cast<double>(options.frame_count) * static_cast<double>(runs.size());
    auto run = RunOnce(options, *plan,
                       [&](uint32_t frames_done) { on_progress((before + frames_done) / all); });
    if (!run.ok()) return run.status();
    runs.push_back(std::move(*run));
  }
  CostTrace trace = MergeRuns(std::move(runs));
  trace.scene = std::filesystem::path(options.scene.name).filename().string();
  trace.seed = options.scene.seed;
  trace.machine = MachineClass();
  trace.repeat_count = options.repeat_count;
  return trace;
}

}  // namespace sweepstake::cli
