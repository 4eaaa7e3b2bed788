// What `sweepstake replay` is asked to do, made ready to run: the words of the command line become
// traced scenes and players. Not thread-safe where it reads files.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "engine_client/cli/replay/replay_study.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

struct ReplayRequest {
  std::vector<std::string> costs{};  // files of cost traces
  std::vector<std::string> policies = {"default", "paper"};
  // Durations as ParseDuration takes them; empty: the default of GameOptions.
  std::string run = "15m";
  std::string frame = "10ms";
  std::string other_work{};
  std::vector<std::string> passes{};  // none, one for all traces, or one for each
  std::string priors = "none";        // none, right, wrong
  bool no_shadow = false;
  uint32_t seed_count = 30;
  uint32_t thread_count = 1;
};

struct ReplayPlan {
  std::vector<StudyScene> scenes;  // one per trace, in order
  StudyOptions study;
};

// Reads the traces. The errors of ReadCosts and ReplayScene::Create; kInvalidArgument says which
// word of the request is wrong and what is valid: durations, players, or traces of other arms.
// REQUIRES: at least one trace.
Result<ReplayPlan> MakeReplayPlan(const ReplayRequest& request);

// `words`: names of policies, `all` for each of them (`default` is one of them under its own name),
// `fixed` for every arm, `fixed:ARM`, `oracle`. kInvalidArgument lists what is valid.
Result<std::vector<ReplayPlayer>> ReplayPlayers(std::span<const std::string> words,
                                                std::span<const std::string> arms);

}  // namespace sweepstake::cli
