// What live runs alone cannot say: how fast each arm truly is on a cell's scene, by a trace of it,
// and what each policy loses to the best fixed arm, by replay on that trace. Beside it what the
// live runs lost, and whether the two agree.
//
// Regret is frame time ÷ that of the best fixed arm, minus 1. Pure but for their time; the same
// traces and records give the same figures.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine_client/cli/experiment/experiment_summary.h"
#include "engine_client/cli/io/statistics.h"
#include "engine_client/cli/trace/cost_trace.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

struct ArmCost {
  std::string arm;
  double mean_ns = 0;  // update and search, over the trace's frames
  double ratio = 1;    // ÷ that of the fastest
};

// A player of replay: a policy, a fixed arm, or the oracle.
struct ReplayedPlayer {
  std::string name;
  bool is_policy = false;
  std::vector<double> regrets;  // by seed
  double regret = 0;            // their mean
  Interval ci95;                // bootstrap
  double after_start_up = 0;
  Interval after_start_up_ci95;
  double switches = 0;
  double active_share = 0;  // of the dominant arm
};

// A policy against a baseline on the same seeds: paired differences of regret, negative where the
// policy loses less.
struct PairedComparison {
  std::string policy;
  std::string baseline;
  double difference = 0;
  Interval ci95;
  WilcoxonResult wilcoxon;
  double corrected_probability = 1;  // Holm, over all comparisons of the family
};

// What one live run lost.
struct LiveRegret {
  uint32_t run = 0;
  double measured = 0;  // frame times against the best arm's alone after the run; machine noise in
  double by_trace = 0;  // the arms' frames at the trace's costs: noise-free
  double active_share = 0;  // of the dominant arm
};

// What the live runs of one policy lost, and the interval that replay puts the mean of as many runs
// in: mean ± 1.96 standard deviations of the games × √(1/runs + 1/games).
struct Agreement {
  std::string policy;
  std::vector<LiveRegret> runs;
  double measured_regret = 0;  // means over the runs
  double regret = 0;           // by trace
  double active_share = 0;
  Interval replayed_regret;
  Interval replayed_active_share;

  bool regret_agrees() const;
  bool share_agrees() const;
};

struct CellTruth {
  ExperimentCell cell;
  std::vector<ArmCost> ranking;  // the fastest first
  double control_ratio = 1;      // of an arm measured twice: what noise alone makes
  double headroom = 0;  // of an oracle that switches at a price, against the best fixed arm
  std::vector<ReplayedPlayer> players;        // empty: not replayed
  std::vector<PairedComparison> comparisons;  // of the policy of AI Decides with every other one
  std::vector<Agreement> agreements;          // per policy that has live runs
};

// All cells that were traced, and AI Decides against each baseline over them.
struct ExperimentTruths {
  std::vector<CellTruth> cells;
  std::vector<PairedComparison> over_cells;  // by replay
  std::vector<PairedComparison> over_live;   // by the live runs

  // Null where the cell was not traced.
  const CellTruth* Of(const ExperimentCell& cell) const;
};

struct TruthOptions {
  uint32_t seed_count = 30;
  uint32_t thread_count = 1;
  double time_scale = 1;  // of the live runs
};

// The trace's part: ranking and control.
CellTruth RankArms(const ExperimentCell& cell, const CostTrace& trace);

// The rest. `cells` are the live summaries of this cell, one per policy; `done` hears the share.
Status AssessCell(const CostTrace& trace, std::span<const CellSummary* const> cells,
                  const TruthOptions& options, const std::function<void(double share)>& done,
                  CellTruth& truth);

// The live runs of AI Decides with those of each other policy, of the same cell and number.
std::vector<PairedComparison> CompareLive(std::span<const CellTruth> truths);

// Over the cells: each cell's mean regret is a pair. Of the policy of AI Decides with every other.
std::vector<PairedComparison> CompareOverCells(std::span<const CellTruth> truths);

// The name of the policy that "default" stands for.
std::string OwnPolicyName(const std::string& policy);

}  // namespace sweepstake::cli
