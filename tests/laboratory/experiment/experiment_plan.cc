#include "tests/laboratory/experiment/experiment_plan.h"

#include <algorithm>
#include <filesystem>
#include <set>
#include <span>

#include "engine_client/cli/game/scene_choice.h"
#include "engine_client/cli/io/duration.h"
#include "engine_client/decider/session/session_setup.h"
#include "engine_client/math/hash.h"
#include "sweepstake/broad_phase.h"
#include "tests/laboratory/experiment/experiment_summary.h"
#include "tests/laboratory/policies/study_policies.h"

namespace sweepstake::cli {
namespace {

template <typename Value>
void Default(std::vector<Value>& values, std::vector<Value> defaults) {
  if (values.empty()) values = std::move(defaults);
}

ExperimentOptions WithDefaults(ExperimentOptions options) {
  Default(options.scenes, {"brownian", "rotating-gravity", "hurricane"});
  if (options.quick) Default(options.object_counts, {1000, 3000});
  // The paper's object counts, and two larger ones, where a wrong choice costs more.
  Default(options.object_counts, {1000, 2000, 3000, 10'000, 50'000});
  Default(options.policies, {"paper", "default"});
  if (options.run_count == 0) options.run_count = options.quick ? 1 : kPaperRunCount;
  if (options.window.empty()) options.window = "15m";
  if (options.trace_frame_count == 0) options.trace_frame_count = options.quick ? 240 : 600;
  if (options.replay_seed_count == 0) options.replay_seed_count = options.quick ? 10 : 30;
  return options;
}

// Derives a run's seed from its cell and number, not from its position in the plan, so that another
// grid with the same cell has the same seeds. Seeds are below 2^53, which every reader of JSON
// represents exactly.
uint64_t RunSeed(uint64_t seed, const std::string& cell, uint32_t run) {
  uint64_t word = math::Mix64(seed + math::kGoldenGamma);
  for (const char letter : cell) word = math::Mix64(word + static_cast<unsigned char>(letter));
  return (math::Mix64(word + run) >> 11) | 1;
}

Status CheckPolicies(std::span<const std::string> policies) {
  for (const std::string& policy : policies) {
    decision::DecisionOptions options;
    options.policy = policy;
    if (const auto problem = decision::Validate(options, decision::StudyPolicies())) {
      return {StatusCode::kInvalidArgument, *problem};
    }
    if (std::count(policies.begin(), policies.end(), policy) > 1) {
      return {StatusCode::kInvalidArgument, "policy \"" + policy + "\" is named twice"};
    }
  }
  return {};
}

Result<std::vector<ExperimentCell>> MakeCells(const ExperimentOptions& options) {
  std::vector<ExperimentCell> cells;
  std::set<std::string> labels;
  for (const SceneChoice& choice :
       ExpandScenes(options.scenes, options.object_counts, options.seed)) {
    const auto scene = OpenScene(choice);
    if (!scene.ok()) return scene.status();
    cells.push_back(
        {choice.name, static_cast<uint32_t>((*scene)->max_object_count()), choice.seed});
    if (!labels.insert(cells.back().label()).second) {
      return Status(StatusCode::kInvalidArgument,
                    "two cells are called " + cells.back().label() + "; remove one of them");
    }
  }
  return cells;
}

std::vector<PlannedRun> MakeRuns(const ExperimentOptions& options,
                                 const std::vector<ExperimentCell>& cells) {
  const auto arm_count = static_cast<uint32_t>(BroadPhaseNames().size());
  std::vector<PlannedRun> runs;
  for (const ExperimentCell& cell : cells) {
    for (uint32_t run = 1; run <= options.run_count; ++run) {
      for (const std::string& policy : options.policies) {
        runs.push_back(
            {cell, policy, run, RunSeed(options.seed, cell.label(), run), (run - 1) % arm_count});
      }
    }
  }
  return runs;
}

}  // namespace

std::string ExperimentCell::label() const {
  return std::filesystem::path(scene).stem().string() + "-" + std::to_string(object_count);
}

std::string PlannedRun::label() const {
  return cell.label() + "-" + policy + "-" + std::to_string(run);
}

Result<ExperimentPlan> MakePlan(const ExperimentOptions& options) {
  ExperimentPlan plan{.options = WithDefaults(options), .window_ns = 0, .cells = {}, .runs = {}};
  if (Status status = CheckPolicies(plan.options.policies); !status.ok()) return status;
  const auto window_ns = ParseDuration(plan.options.window);
  if (!window_ns.ok()) return window_ns.status();
  plan.window_ns = static_cast<uint64_t>(static_cast<double>(*window_ns) / plan.options.time_scale);
  auto cells = MakeCells(plan.options);
  if (!cells.ok()) return cells.status();
  plan.cells = std::move(*cells);
  plan.runs = MakeRuns(plan.options, plan.cells);
  return plan;
}

}  // namespace sweepstake::cli
