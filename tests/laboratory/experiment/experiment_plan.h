// The plan of an experiment: the cells of its grid, the policies, and each run with its seeds in
// the order of execution. Plain values and pure functions, safe from any thread.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engine_client/decider/options.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

// The options as the user gave them. For empty lists and zeros, MakePlan uses the defaults of
// `--quick` or of the paper's grid.
struct ExperimentOptions {
  std::string grid = "paper";  // one of kExperimentGrids; determines the defaults
  std::vector<std::string> scenes;
  std::vector<uint32_t> object_counts;
  std::vector<std::string> policies;
  uint32_t run_count = 0;
  std::string window;     // length of the observation after the exploration
  double time_scale = 1;  // divides the window and all intervals except the bail-out's
  uint64_t seed = 1;
  uint32_t trace_frame_count = 0;
  uint32_t replay_seed_count = 0;
  decision::DecisionOptions decision;  // before the time scale; `policy` is each run's
  // Duration of the game's work in each frame besides the scene's motion and the search; empty:
  // none. Not divided by the time scale.
  std::string other_work;
  bool quick = false;  // fewer object counts, one run each
};

// The paper's grid with two larger object counts, and a grid in which different arms are the
// fastest, also within a cell.
inline constexpr std::array<std::string_view, 2> kExperimentGrids = {"paper", "crossovers"};

struct ExperimentCell {
  std::string scene;  // a value of --scene
  uint32_t object_count = 0;

  // Returns e.g. "brownian-1000"; for a recording the file's name without folder and extension.
  std::string label() const;
  friend bool operator==(const ExperimentCell&, const ExperimentCell&) = default;
};

// One scene of a cell. Runs of a cell with different numbers have different scenes, so that their
// spread and the paired tests include the variation between scenes. A scene whose boxes do not
// depend on the seed, such as a recording, is the only one of its cell.
struct PlannedScene {
  ExperimentCell cell;
  uint32_t run = 0;   // the first run that plays it, from 1
  uint64_t seed = 0;  // of the scene

  // Returns "brownian-1000-1".
  std::string label() const;
  friend bool operator==(const PlannedScene&, const PlannedScene&) = default;
};

// All policies of a run number have the same scene, seed and initial arm, so they are compared in
// pairs.
struct PlannedRun {
  ExperimentCell cell;
  std::string policy;
  uint32_t run = 0;          // from 1
  uint64_t scene_seed = 0;   // of the scene
  uint64_t seed = 0;         // for the decider
  uint32_t initial_arm = 0;  // index of the first active arm; differs from run to run

  // Returns "brownian-1000-paper-1".
  std::string label() const;
  friend bool operator==(const PlannedRun&, const PlannedRun&) = default;
};

// The options with the defaults filled in, and the runs.
struct ExperimentPlan {
  ExperimentOptions options;
  uint64_t window_ns = 0;  // in real time, that is, divided by the time scale
  uint64_t other_work_ns = 0;
  std::vector<ExperimentCell> cells;
  std::vector<PlannedScene> scenes;  // ordered by cell, then run
  // Ordered by cell, then run, then policy. Runs that are compared follow one another, so that a
  // disturbance of the machine affects them alike.
  std::vector<PlannedRun> runs;
};

// Makes the plan. Errors: kInvalidArgument or kNotFound (a policy, window or scene is not valid).
Result<ExperimentPlan> MakePlan(const ExperimentOptions& options);

}  // namespace sweepstake::cli
