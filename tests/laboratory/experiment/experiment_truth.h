// Computes figures that live runs alone cannot give. Traces of a cell's scenes give the true cost
// of each arm. Replay on these traces gives the regret of each policy against the best fixed arm,
// for comparison with the regret of the live runs.
//
// The scene is the unit of the statistics: games on the same scene differ only by the decider's
// seed, and are first averaged. Intervals and tests of a cell have one value per scene.
//
// Regret is frame time ÷ frame time of the best fixed arm, minus 1. The functions are pure: the
// same traces and records give the same figures.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine_client/cli/io/statistics.h"
#include "sweepstake/status.h"
#include "tests/laboratory/experiment/experiment_summary.h"
#include "tests/laboratory/replay/replay_study.h"
#include "tests/laboratory/trace/cost_trace.h"

namespace sweepstake::cli {

struct ArmCost {
  std::string arm;
  double mean_ns = 0;  // update and search, over the frames of all scenes
  double ratio = 1;    // mean_ns ÷ mean_ns of the fastest arm
};

// The result of one player in replay. A player is a policy, a fixed arm, or the oracle.
struct ReplayedPlayer {
  std::string name;
  bool is_policy = false;
  StudyRow row;  // the games on all scenes; ci95 is the interval of the mean over the scenes
  std::vector<double> scene_regrets;  // mean regret of the games on each scene
};

// The regret of one live run, computed in two ways: from the measured frame times, and from the
// trace's mean costs of the arms that it ran.
struct LiveRegret {
  uint32_t run = 0;
  double measured = 0;      // against the best arm's control run; includes machine noise
  double by_trace = 0;      // from the trace's costs, without machine noise
  double active_share = 0;  // share of the time in which the dominant arm was active
};

// The regret of the live runs of one policy, and the interval in which replay expects their mean:
// mean ± 1.96 standard deviations of the games × √(1/runs + 1/games).
struct Agreement {
  std::string policy;
  std::vector<LiveRegret> runs;
  double measured_regret = 0;  // mean of LiveRegret::measured over the runs
  double regret = 0;           // mean of LiveRegret::by_trace over the runs
  double active_share = 0;     // mean of LiveRegret::active_share over the runs
  Interval replayed_regret;
  Interval replayed_active_share;

  bool regret_agrees() const;
  bool share_agrees() const;
};

// What a choice of the arm is worth in a cell. All times are milliseconds of detection per frame at
// the speed of the traces, means over the games.
struct Worth {
  std::string best_arm;   // the single arm with the least time, which is not known beforehand
  double best_ms = 0;     // always best_arm
  double always_ms = 0;   // always kAlwaysArm
  double oracle_ms = 0;   // the best sequence of arms, including its switches
  double decided_ms = 0;  // AI Decides

  double saved_to_best_ms() const { return best_ms - oracle_ms; }
  double saved_to_always_ms() const { return always_ms - oracle_ms; }
  // Whether the oracle saves less than kMinHeadroom of the time, or less than kMinWorthMs, against
  // both single arms.
  bool is_nothing() const;
};
// 0.06 % of a frame at 60 Hz.
inline constexpr double kMinWorthMs = 0.01;
// The arm of the baseline that never chooses: the fastest one in most scenes.
inline constexpr std::string_view kAlwaysArm = "KDTree";

struct CellTruth {
  ExperimentCell cell;
  uint32_t scene_count = 0;
  std::vector<ArmCost> ranking;  // in ascending order of cost
  // Time of a second structure of one arm ÷ time of the first; differs from 1 by noise only. The
  // ratio of the scene in which it differs most.
  double control_ratio = 1;
  double headroom = 0;                  // StudyGame::headroom (replay_study.h)
  std::optional<Worth> worth;           // absent if not replayed, or without kAlwaysArm
  std::vector<ReplayedPlayer> players;  // empty if not replayed
  // AI Decides against each other policy and against always kAlwaysArm.
  std::vector<PairedComparison> comparisons;
  std::vector<Agreement> agreements;  // one per policy with live runs
};

// All traced cells, and the comparisons of AI Decides with each baseline over them.
struct ExperimentTruths {
  std::vector<CellTruth> cells;
  std::vector<PairedComparison> over_cells;

  // Returns null if the cell was not traced.
  const CellTruth* Of(const ExperimentCell& cell) const;
};

struct TruthOptions {
  uint32_t seed_count = 30;  // games of a player in a cell, divided evenly among its scenes
  uint32_t thread_count = 1;
  double time_scale = 1;                    // time scale of the live runs
  decision::DecisionOptions decision = {};  // before the time scale; `policy` is each player's
};

// Returns the figures that need only the traces: the ranking of the arms and the control ratio.
// REQUIRES: at least one trace; all have the same arms.
CellTruth RankArms(const ExperimentCell& cell, std::span<const CostTrace> traces);

// Adds the figures that need replay to a CellTruth. `cells` are the summaries of the live runs in
// this cell, one per policy. `done` is called with the finished share. REQUIRES: each run has the
// seed of one of the traces; all traces have the same arms.
Status AssessCell(std::span<const CostTrace> traces, std::span<const CellSummary* const> cells,
                  const TruthOptions& options, const std::function<void(double share)>& done,
                  CellTruth& truth);

// Compares AI Decides with every other policy and with always kAlwaysArm by paired tests over the
// cells. The two values of a pair are the mean regrets of both in the same cell.
std::vector<PairedComparison> CompareOverCells(std::span<const CellTruth> truths);

// Returns the name of the policy. For "default", returns the name of the policy that is the
// default.
std::string OwnPolicyName(const std::string& policy);

}  // namespace sweepstake::cli
