// What an experiment runs: the cells of its grid, the policies, and each run with its seeds, in the
// order of the runs. Plain values and pure functions, safe from any thread.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sweepstake/status.h"

namespace sweepstake::cli {

// Empty lists and zeros stand for the defaults of `--quick` or of the paper's grid.
struct ExperimentOptions {
  std::vector<std::string> scenes;
  std::vector<uint32_t> object_counts;
  std::vector<uint32_t> large_object_counts;  // a second grid, where the choice costs more
  std::vector<std::string> policies;
  uint32_t run_count = 0;
  std::string window;     // observed after the exploration
  double time_scale = 1;  // divides the window and every interval of the decider but the bail-out
  uint64_t seed = 1;
  uint32_t trace_frame_count = 0;
  uint32_t replay_seed_count = 0;
  bool quick = false;   // six cells, one run each
  bool frames = false;  // keep every frame's metrics
};

struct ExperimentCell {
  std::string scene;  // as --scene takes it
  uint32_t object_count = 0;
  uint64_t scene_seed = 0;

  // "brownian-1000"; for a recording the file's name without folder and ending.
  std::string label() const;
  friend bool operator==(const ExperimentCell&, const ExperimentCell&) = default;
};

struct PlannedRun {
  ExperimentCell cell;
  std::string policy;
  uint32_t run = 0;          // from 1
  uint64_t seed = 0;         // of the decisions; the same for all policies of a cell's run
  uint32_t initial_arm = 0;  // rotates over the runs

  // "brownian-1000-paper-1".
  std::string label() const;
};

// `options` with the defaults filled in.
struct ExperimentPlan {
  ExperimentOptions options;
  uint64_t window_ns = 0;  // real time: divided by the time scale
  std::vector<ExperimentCell> cells;
  // By cell, then run, then policy: what is compared runs one after the other, so that what
  // disturbs the machine disturbs all alike.
  std::vector<PlannedRun> runs;

  // Of one run, real time: exploration of all arms, window, and the controls after it.
  uint64_t expected_run_ns() const;
};

// kInvalidArgument, kNotFound: a policy, a window or a scene that there is not.
Result<ExperimentPlan> MakePlan(const ExperimentOptions& options);

}  // namespace sweepstake::cli
