// Plans `sweepstake-lab replay`: converts the command line's words into traced scenes and players.
// It reads files and is not thread-safe.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "sweepstake/status.h"
#include "tests/laboratory/replay/replay_study.h"

namespace sweepstake::cli {

struct ReplayRequest {
  std::vector<std::string> costs{};  // cost trace files
  std::vector<std::string> policies = {"default", "paper"};
  // Durations in the form of ParseDuration; empty: the default of GameOptions.
  std::string run = "15m";
  std::string frame = "10ms";
  std::string other_work{};
  std::vector<std::string> passes{};  // none, one for all traces, or one for each
  std::string priors = "none";        // REQUIRES: one of kReplayPriorsNames
  bool no_shadow = false;
  LaneErrors lane_errors{};  // REQUIRES: no arm_ratios, which lane_ratios name
  std::vector<std::pair<std::string, std::string>> lane_ratios{};  // arm and number
  FrameLoad frame_load{};
  uint32_t seed_count = 30;
  uint32_t thread_count = 1;
};

struct ReplayPlan {
  std::vector<StudyScene> scenes;  // one per trace, in order
  StudyOptions study;
};

// Reads the traces. Errors: those of ReadCosts and ReplayScene::Create, and kInvalidArgument (a
// duration or player is not valid, or the traces have different arms). The message lists the valid
// values. REQUIRES: at least one trace.
Result<ReplayPlan> MakeReplayPlan(const ReplayRequest& request);

// Returns the players that `words` names: a policy, `all` policies (`default` is among them under
// its own name), `fixed` for every arm, `fixed:ARM`, `oracle`. Error: kInvalidArgument (lists what
// is valid).
Result<std::vector<ReplayPlayer>> ReplayPlayers(std::span<const std::string> words,
                                                std::span<const std::string> arms);

}  // namespace sweepstake::cli
