// Who plays a traced scene: a policy, one arm all the time, or the oracle. Pure.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "sweepstake/status.h"

namespace sweepstake::cli {

struct ReplayPlayer {
  enum class Kind { kPolicy, kFixed, kOracle };
  std::string name;  // "paper", "fixed:SAP", "oracle"
  Kind kind = Kind::kPolicy;
  uint32_t arm = 0;  // of kFixed
};

// `words`: names of policies, `all` for each of them (but `default`, which is one of them), `fixed`
// for every arm, `fixed:ARM`, `oracle`. kInvalidArgument lists
// what is valid.
Result<std::vector<ReplayPlayer>> ReplayPlayers(std::span<const std::string> words,
                                                std::span<const std::string> arms);

}  // namespace sweepstake::cli
