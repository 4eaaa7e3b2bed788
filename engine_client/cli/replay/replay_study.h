// Many seeds of many players on many traced scenes, in parallel, and what they come to.
//
// The result does not depend on the number of threads. Regret is frame time ÷ that of the best
// fixed arm on the same frames, minus 1: negative is better than any fixed arm.
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
#include "engine_client/cli/replay/replay_run.h"
#include "engine_client/cli/replay/replay_scene.h"

namespace sweepstake::cli {

// Who plays a traced scene: a policy, one arm all the time, or the oracle that knows everything.
struct ReplayPlayer {
  enum class Kind { kPolicy, kFixed, kOracle };
  std::string name;  // "paper", "fixed:SAP", "oracle"
  Kind kind = Kind::kPolicy;
  uint32_t arm = 0;  // of kFixed
};

enum class ReplayPriors {
  kNone,
  kRight,  // what another seed's run of the same policy on the same trace had learnt at its end
  kWrong,  // the same, the arms' ranking reversed
};
inline constexpr std::array<std::string_view, 3> kReplayPriorsNames = {"none", "right", "wrong"};

struct StudyOptions {
  std::vector<ReplayPlayer> players;
  decision::DecisionOptions decision;  // its policy is each player's own
  uint32_t seed_count = 30;
  ReplayPriors priors = ReplayPriors::kNone;
  std::optional<bool> shadow_lane;  // absent: for the policies that learn from it
  uint32_t thread_count = 1;
  ShadowScheduleOptions shadow = {};
};

struct StudyScene {
  std::string name;
  ReplayScene scene;
};

// One player's game with one seed.
struct StudyGame {
  double regret_best_fixed = 0;
  double regret_oracle = 0;  // against the oracle that pays for its switches
  double regret_after_start_up = 0;
  double headroom = 0;        // of that oracle: 1 − its time ÷ the best fixed arm's
  double frame_headroom = 0;  // of the best arm in every frame, switching for nothing
  uint64_t switch_count = 0;  // after the exploration
  double active_share = 1;    // of the dominant arm
  uint32_t dominant_arm = 0;
  std::optional<uint64_t> bail_out_count{};  // of a policy
  std::vector<double> verdict_shares{};      // of a policy's ticks, by Verdict
  std::optional<double> first_best_s{};      // when a policy first chose the best fixed arm
  double shadow_share = 0;                   // of the time, that the shadow lane worked
  bool operator==(const StudyGame&) const = default;
};

// All games of one player on one scene.
struct StudyRow {
  uint32_t scene = 0;
  uint32_t player = 0;
  std::vector<StudyGame> games;  // by seed, from 1

  double regret_best_fixed = 0;  // means over the games, as all below
  Interval ci95;                 // of it
  double regret_oracle = 0;
  double regret_after_start_up = 0;
  Interval after_start_up_ci95;
  double headroom = 0;
  double frame_headroom = 0;
  std::optional<double> headroom_captured;  // absent: less than kMinHeadroom is there
  double switches = 0;
  double active_share = 0;
  uint32_t dominant_arm = 0;  // in most games
  std::optional<double> bail_outs;
  std::vector<double> verdict_shares;
  std::optional<double> first_best_s;
  double shadow_share = 0;
  struct AgainstPaper {
    double difference = 0;  // of regret_best_fixed, paired by seed
    Interval ci95;
    double probability = 1;  // Wilcoxon's
  };
  std::optional<AgainstPaper> against_paper;
};

inline constexpr double kMinHeadroom = 0.005;

// Rows by scene, then by player. `on_game` hears from the calling thread how many of all games are
// done. REQUIRES: valid decision options; scenes with the same arms.
std::vector<StudyRow> RunStudy(std::span<const StudyScene> scenes, const StudyOptions& options,
                               const std::function<void(uint64_t done, uint64_t all)>& on_game);

}  // namespace sweepstake::cli
