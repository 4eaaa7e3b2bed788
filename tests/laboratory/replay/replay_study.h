// Plays many seeds of many players on many traced scenes in parallel, and summarizes the games.
//
// The result does not depend on the number of threads. Regret is frame time ÷ that of the best
// fixed arm on the same frames, minus 1; it is negative for a player that beats every fixed arm.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine_client/cli/io/statistics.h"
#include "tests/laboratory/replay/replay_priors.h"
#include "tests/laboratory/replay/replay_run.h"
#include "tests/laboratory/replay/replay_scene.h"

namespace sweepstake::cli {

// The player of a traced scene: a policy, one fixed arm, or the oracle that knows all costs.
struct ReplayPlayer {
  enum class Kind { kPolicy, kFixed, kOracle };
  std::string name;  // "paper", "fixed:SAP", "oracle"
  Kind kind = Kind::kPolicy;
  uint32_t arm = 0;  // for kFixed
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

// Times of a frame in milliseconds as they were recorded, other work left out.
struct FrameMs {
  double detection = 0;  // the player's
  double best = 0;       // the best fixed arm's
  double median = 0;     // the median of the fixed arms
  double worst = 0;      // the worst fixed arm's
  double lane = 0;       // CPU time of the shadow lane, on another core

  double regret() const { return detection - best; }
  // The share of the best fixed arm's detection.
  double regret_ratio() const { return best > 0 ? regret() / best : 0; }
  bool operator==(const FrameMs&) const = default;
};
// The time of a frame at 60 Hz.
inline constexpr double kFrameMsAt60Hz = 1000.0 / 60;

// The result of one player's game with one seed.
struct StudyGame {
  double regret_best_fixed = 0;
  double regret_oracle = 0;  // regret against the oracle that pays for its switches
  // Without the first minute and the exploration. Absent if nothing came after them, and for the
  // oracle.
  std::optional<double> regret_after_start_up{};
  double headroom = 0;        // of that oracle: 1 − its time ÷ the best fixed arm's
  double frame_headroom = 0;  // of an oracle with the best arm in every frame and free switches
  uint64_t switch_count = 0;  // after the exploration
  uint64_t after_start_up_switch_count = 0;  // policies only: after the first minute, too
  double active_share = 1;                   // the dominant arm's
  uint32_t dominant_arm = 0;
  std::optional<uint64_t> bail_out_count{};  // policies only
  std::vector<double> verdict_shares{};      // policies only: of ticks, by Verdict
  std::optional<double> first_best_s{};      // when a policy first chose the best fixed arm
  std::optional<double> first_loss{};        // regret of the first choice, if kept
  std::optional<double> opening_regret{};    // policies only: regret of the first 10 s
  double shadow_share = 0;                   // share of the time that the shadow lane worked
  FrameMs ms{};
  Reliability reliability{};  // of a policy's decisions
  bool operator==(const StudyGame&) const = default;
};

// The results of one player on one scene.
struct StudyRow {
  uint32_t scene = 0;
  uint32_t player = 0;
  std::vector<StudyGame> games;  // by seed, from 1

  // The means over the games of the members of StudyGame with these names.
  double regret_best_fixed = 0;
  double regret_oracle = 0;
  double headroom = 0;
  double frame_headroom = 0;
  double active_share = 0;
  std::vector<double> verdict_shares;
  double shadow_share = 0;
  FrameMs ms;

  Reliability reliability;                      // of the decisions of all games
  std::optional<double> paper_ms;               // the paper's detection on the same scene
  Interval ci95;                                // 95 % interval of regret_best_fixed
  std::optional<double> regret_after_start_up;  // mean over the games that have one
  std::optional<Interval> after_start_up_ci95;  // its 95 % interval
  std::optional<double> headroom_captured;      // absent if the headroom is below kMinHeadroom
  double switches = 0;                          // mean of StudyGame::switch_count
  double after_start_up_switches = 0;           // mean
  uint32_t dominant_arm = 0;                    // in the largest number of games
  std::optional<double> bail_outs;              // mean of StudyGame::bail_out_count
  std::optional<double> first_best_s;           // median over the games that have one
  std::optional<double> first_right;            // share with a first_loss of at most kTieLossRatio
  std::optional<double> opening_regret;         // mean
  struct AgainstPaper {
    double difference = 0;  // of regret_best_fixed, paired by seed
    Interval ci95;
    double probability = 1;  // by Wilcoxon's test
  };
  std::optional<AgainstPaper> against_paper;
};

inline constexpr double kMinHeadroom = 0.005;

// Plays all games. The rows are ordered by scene, then by player. `on_game` is called on the
// calling thread with the number of games done. REQUIRES: the decision options are valid; all
// scenes have the same arms.
std::vector<StudyRow> RunStudy(std::span<const StudyScene> scenes, const StudyOptions& options,
                               const std::function<void(uint64_t done, uint64_t all)>& on_game);

}  // namespace sweepstake::cli
