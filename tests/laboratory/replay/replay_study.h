// Replays traced scenes with each player (a policy, a fixed arm or the oracle) and many seeds, in
// parallel. A game is one replay of one scene by one player with one seed. Summarizes the games.
//
// The result does not depend on the number of threads. Regret is frame time ÷ time of the best
// fixed arm on the same frames, minus 1; it is negative for a player that beats every fixed arm.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine_client/cli/io/statistics.h"
#include "tests/laboratory/replay/replay_priors.h"
#include "tests/laboratory/replay/replay_run.h"
#include "tests/laboratory/replay/replay_scene.h"

namespace sweepstake::cli {

// A player of a traced scene: a policy, one fixed arm, or the oracle, which has all costs in
// advance.
struct ReplayPlayer {
  enum class Kind { kPolicy, kFixed, kOracle };
  std::string name;  // "paper", "fixed:SAP", "oracle"
  Kind kind = Kind::kPolicy;
  uint32_t arm = 0;  // the arm of kFixed
};

struct StudyOptions {
  std::vector<ReplayPlayer> players;
  decision::DecisionOptions decision;  // `policy` is replaced by each player's
  uint32_t seed_count = 30;
  ReplayPriors priors = ReplayPriors::kNone;
  std::optional<bool> shadow_lane;  // absent: on for policies that learn from it
  uint32_t thread_count = 1;
  ShadowScheduleOptions shadow = {};
  LaneErrors lane_errors = {};
  FrameLoad frame_load = {};
};

struct StudyScene {
  std::string name;
  ReplayScene scene;
};

// Milliseconds of a frame at the speed of the recording, without other work.
struct FrameMs {
  double detection = 0;  // with this player
  double best = 0;       // with the best fixed arm
  double median = 0;     // with the median of the fixed arms
  double worst = 0;      // with the worst fixed arm
  double lane = 0;       // CPU time of the shadow lane, on another core

  double regret() const { return detection - best; }
  // The regret as a share of the best fixed arm's detection time.
  double regret_ratio() const { return best > 0 ? regret() / best : 0; }
  bool operator==(const FrameMs&) const = default;
};
// The time of a frame at 60 Hz.
inline constexpr double kFrameMsAt60Hz = 1000.0 / 60;

// The figures of one game: one player with one seed. In a StudyRow they are means over the games.
struct StudyGame {
  double regret_best_fixed = 0;
  double regret_oracle = 0;   // against the oracle that pays for its switches
  double headroom = 0;        // 1 − time of the oracle ÷ time of the best fixed arm
  double frame_headroom = 0;  // headroom of an oracle that switches freely in every frame
  double switches = 0;        // number of switches after the exploration
  // Policies only: switches after the exploration and the first minute.
  double after_start_up_switches = 0;
  double active_share = 1;  // share of the time on the dominant arm
  double shadow_share = 0;  // share of the time that the shadow lane worked
  // The regret without the first minute and the exploration. Absent for the oracle, and if no
  // frames are left.
  std::optional<double> regret_after_start_up{};
  // The following figures are absent or empty for fixed arms and the oracle.
  std::optional<double> bail_outs{};
  std::optional<double> first_best_s{};  // when the policy first chose the best fixed arm
  // 1 if the first chosen arm is at most kTieLossRatio slower than the best, else 0.
  std::optional<double> first_right{};
  std::optional<double> opening_regret{};  // regret of the first 10 s
  std::vector<double> verdict_shares{};    // share of the ticks with each Verdict
  FrameMs ms{};
  Reliability reliability{};  // of a policy's decisions; in a StudyRow: summed over the games
  uint32_t dominant_arm = 0;  // in a StudyRow: the most frequent one of the games
  bool operator==(const StudyGame&) const = default;
};

// Compares a policy with a baseline by the differences of their regrets with the same seed. A
// negative difference means that the policy has less regret.
struct PairedComparison {
  std::string policy;
  std::string baseline;
  double difference = 0;
  Interval ci95;
  WilcoxonResult wilcoxon;
  double corrected_probability = 1;  // Holm's correction over all comparisons of a family
};
PairedComparison Compare(const std::string& policy, std::span<const double> ours,
                         const std::string& baseline, std::span<const double> theirs);

// The results of one player on one scene. Each figure is the mean over the games in which it is
// present; first_best_s is the median.
struct StudyRow : StudyGame {
  uint32_t scene = 0;
  uint32_t player = 0;
  std::vector<StudyGame> games;                 // by seed, from 1
  Interval ci95;                                // 95 % interval of regret_best_fixed
  std::optional<Interval> after_start_up_ci95;  // of regret_after_start_up
  std::optional<double> headroom_captured;      // absent if the headroom is below kMinHeadroom
  // Detection time with the policy `paper` on the same scene.
  std::optional<double> paper_ms;
  std::optional<PairedComparison> against_paper;  // the games with the same seeds are compared

  std::vector<double> Values(double StudyGame::*figure) const;  // one per game
};

inline constexpr double kMinHeadroom = 0.005;

// Computes the figures of a row from its games. Leaves scene, player and the comparison with the
// paper unchanged. REQUIRES: at least one game.
void SummarizeGames(StudyRow& row);

// Plays all games. The rows are ordered by scene, then by player. `on_game` is called on the
// calling thread with the number of games done. REQUIRES: the decision options are valid; all
// scenes have the same arms.
std::vector<StudyRow> RunStudy(std::span<const StudyScene> scenes, const StudyOptions& options,
                               const std::function<void(uint64_t done, uint64_t all)>& on_game);

// The options of `sweepstake-lab replay --costs` as the user typed them.
struct ReplayRequest {
  std::vector<std::string> costs{};  // cost trace files
  std::vector<std::string> policies = {"default", "paper"};
  std::string run = "15m";            // a duration in the form of ParseDuration
  std::vector<std::string> passes{};  // durations: none, one for all traces, or one for each
  std::string priors = "none";        // REQUIRES: one of kReplayPriorsNames
  bool no_shadow = false;
  std::vector<std::pair<std::string, std::string>> lane_ratios{};  // arm and its ratio, as typed
  // Further options. MakeReplayPlan sets its players, priors and lane from the texts above.
  StudyOptions study{};
};

struct ReplayPlan {
  std::vector<StudyScene> scenes;  // one per trace, in order
  StudyOptions study;
};

// Reads the traces. Errors: those of ReadCosts and ReplayScene::Create, and kInvalidArgument (a
// duration or player is not valid, or the traces have different arms). The message lists the valid
// values. REQUIRES: at least one trace.
Result<ReplayPlan> MakeReplayPlan(const ReplayRequest& request);

// Returns the players with these names: a policy, `all` policies, `fixed` for every arm,
// `fixed:ARM`, or `oracle`. `all` contains the default policy once, under its own name. Error:
// kInvalidArgument (the message lists the valid names).
Result<std::vector<ReplayPlayer>> ReplayPlayers(std::span<const std::string> words,
                                                std::span<const std::string> arms);

}  // namespace sweepstake::cli
