// The setup of a session, and its validation.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine_client/decider/options.h"
#include "engine_client/decider/session/policy_registry.h"
#include "engine_client/decider/types.h"

namespace sweepstake::decision {

inline constexpr uint32_t kMaxArms = 32;
inline constexpr double kMaxPriorEvidence = 1e15;  // alpha and beta of a prior are below it
// Number of regimes in which the evidence of a scene is stored. Sessions store the evidence of
// further regimes without a regime. Sessions that begin at the same time, and imports, can exceed
// it; a prior then uses the regimes with the most evidence.
inline constexpr uint32_t kMaxStoredRegimes = 8;
inline constexpr uint32_t kMaxRegimePriors = 16;

struct SessionSetup {
  DecisionOptions options;
  std::vector<std::string> arms;  // 1 to kMaxArms unique, non-empty names
  // One prior per arm, or empty for Beta(1,1) for each. Both parameters are > 0 and <
  // kMaxPriorEvidence.
  std::vector<BetaPosterior> priors;
  // Priors of regimes, which replace `priors` when such a regime begins. At most kMaxRegimePriors.
  RegimePriors regime_priors;
  uint64_t seed = 1;  // determines the exploration order and all draws
  Mode mode = Mode::kAi;
  uint32_t active_arm = 0;
  // The arm with which the game begins, and which it would keep without a decider. After a lost
  // connection or a restart, active_arm is a later one. Only reports depend on it.
  uint32_t initial_arm = 0;
  uint32_t switch_epoch = 0;
  int64_t start_ns = 0;
  // The counts before a restart, if the session continues after one; otherwise 0.
  uint32_t explored_arm_count = 0;
  uint64_t decision_count = 0;
  // Whether the game bounds the cost of a trial, as AdaptiveBroadPhase does. Otherwise no trials
  // are commanded.
  bool stops_trials = true;
};

// Returns one line per invalid option, with the correction. Looks up the policy's name in
// `policies`.
std::vector<std::string> Problems(const DecisionOptions& options, PolicyRegistry policies);
// Returns one line about the first invalid value, with the correction. Returns nothing if all are
// valid. Looks up policy names in `policies`.
std::optional<std::string> Validate(const DecisionOptions& options, PolicyRegistry policies);
std::optional<std::string> Validate(const SessionSetup& setup, PolicyRegistry policies);

}  // namespace sweepstake::decision
