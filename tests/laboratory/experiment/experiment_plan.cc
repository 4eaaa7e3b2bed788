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
  const bool crosses = options.grid == "crossovers";
  if (crosses) {
    // Objects at rest, teleporting, in storms, clustered, and two scenes whose count grows.
    Default(options.scenes,
            {"nearly-resting", "teleporting", "storms", "clusters", "arrivals", "waves"});
    if (!options.quick) Default(options.object_counts, {1000, 10'000, 100'000});
    // Two regimes of storms.
    if (options.trace_frame_count == 0) options.trace_frame_count = 800;
  }
  Default(options.scenes, {"brownian", "rotating-gravity", "hurricane"});
  if (options.quick) Default(options.object_counts, {1000, 3000});
  // The paper's object counts, and two larger ones, where a wrong choice costs more.
  Default(options.object_counts, {1000, 2000, 3000, 10'000, 50'000});
  Default(options.policies, {"paper", "default"});
  if (options.run_count == 0) options.run_count = options.quick ? 1 : kPaperRunCount;
  if (options.window.empty()) options.window = "15m";
  // Two directions of rotating gravity, or more than one. Each scene of a cell has a trace.
  if (options.trace_frame_count == 0) options.trace_frame_count = options.quick ? 240 : 360;
  if (options.replay_seed_count == 0) options.replay_seed_count = options.quick ? 10 : 30;
  return options;
}

enum class SeedPurpose : uint64_t { kDecisions = 1, kScene = 2 };

// Derives a seed from the cell and the run's number, not from the position in the plan, so that
// another grid with the same cell has the same seeds. Seeds are below 2^53, which every reader of
// JSON represents exactly.
uint64_t SeedOf(SeedPurpose purpose, uint64_t seed, const std::string& cell, uint32_t run) {
  uint64_t word = math::Mix64(seed + static_cast<uint64_t>(purpose) * math::kGoldenGamma);
  for (const char letter : cell) word = math::Mix64(word + static_cast<unsigned char>(letter));
  return (math::Mix64(word + run) >> 11) | 1;
}

Status CheckPolicies(const ExperimentOptions& options) {
  const std::vector<std::string>& policies = options.policies;
  for (const std::string& policy : policies) {
    decision::DecisionOptions decision = options.decision;
    decision.policy = policy;
    if (const auto problem = decision::Validate(decision, decision::StudyPolicies())) {
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
    cells.push_back({choice.name, static_cast<uint32_t>((*scene)->max_object_count())});
    if (!labels.insert(cells.back().label()).second) {
      return Status(StatusCode::kInvalidArgument,
                    "two cells are called " + cells.back().label() + "; remove one of them");
    }
  }
  return cells;
}

// Returns the boxes of the first frames of the scene with this seed.
std::vector<Aabb> FirstBoxes(const ExperimentCell& cell, uint64_t seed) {
  constexpr int kFrames = 3;
  const auto scene = OpenScene({cell.scene, cell.object_count, seed});
  std::vector<Aabb> boxes;
  for (int frame = 0; frame < kFrames; ++frame) {
    const auto shown = (*scene)->aabbs();
    boxes.insert(boxes.end(), shown.begin(), shown.end());
    (*scene)->Step();
  }
  return boxes;
}

// Returns the scenes of a cell. REQUIRES: the cell's scene can be opened.
std::vector<PlannedScene> ScenesOf(const ExperimentOptions& options, const ExperimentCell& cell) {
  std::vector<PlannedScene> scenes;
  for (uint32_t run = 1; run <= options.run_count; ++run) {
    const uint64_t seed = SeedOf(SeedPurpose::kScene, options.seed, cell.label(), run);
    if (run == 2 && FirstBoxes(cell, seed) == FirstBoxes(cell, scenes.front().seed)) break;
    scenes.push_back({cell, run, seed});
  }
  return scenes;
}

void AddRuns(const ExperimentCell& cell, ExperimentPlan& plan) {
  const auto arm_count = static_cast<uint32_t>(BroadPhaseNames().size());
  const ExperimentOptions& options = plan.options;
  const std::vector<PlannedScene> scenes = ScenesOf(options, cell);
  for (uint32_t run = 1; run <= options.run_count; ++run) {
    const PlannedScene& scene = scenes[std::min<size_t>(run, scenes.size()) - 1];
    const uint64_t seed = SeedOf(SeedPurpose::kDecisions, options.seed, cell.label(), run);
    for (const std::string& policy : options.policies) {
      plan.runs.push_back({cell, policy, run, scene.seed, seed, (run - 1) % arm_count});
    }
  }
  plan.scenes.insert(plan.scenes.end(), scenes.begin(), scenes.end());
}

}  // namespace

std::string ExperimentCell::label() const {
  return std::filesystem::path(scene).stem().string() + "-" + std::to_string(object_count);
}

std::string PlannedScene::label() const { return cell.label() + "-" + std::to_string(run); }

std::string PlannedRun::label() const {
  return cell.label() + "-" + policy + "-" + std::to_string(run);
}

Result<ExperimentPlan> MakePlan(const ExperimentOptions& options) {
  ExperimentPlan plan;
  plan.options = WithDefaults(options);
  if (Status status = CheckPolicies(plan.options); !status.ok()) return status;
  const auto window_ns = ParseDuration(plan.options.window);
  if (!window_ns.ok()) return window_ns.status();
  plan.window_ns = static_cast<uint64_t>(static_cast<double>(*window_ns) / plan.options.time_scale);
  if (!plan.options.other_work.empty()) {
    const auto other_work_ns = ParseDuration(plan.options.other_work);
    if (!other_work_ns.ok()) return other_work_ns.status();
    plan.other_work_ns = *other_work_ns;
  }
  auto cells = MakeCells(plan.options);
  if (!cells.ok()) return cells.status();
  plan.cells = std::move(*cells);
  for (const ExperimentCell& cell : plan.cells) AddRuns(cell, plan);
  return plan;
}

}  // namespace sweepstake::cli
