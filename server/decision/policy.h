// Choosing: posteriors to a candidate arm. Choosing changes no state, neither the policy's nor
// anyone else's.
//
// Policies are immutable and safe to use from several threads.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "server/decision/types.h"

namespace sweepstake::decision {

struct ChoiceInput {
  std::span<const BetaPosterior> posteriors;  // one per arm, at least one
  uint32_t active_arm = 0;
  uint64_t seed = 0;
  uint64_t decision_id = 0;  // with the seed, all the randomness there is
};

struct Choice {
  uint32_t candidate = 0;
  std::vector<double> draws;  // one per arm, as the policy compared them
};

class Policy {
 public:
  virtual ~Policy() = default;
  virtual Choice Choose(const ChoiceInput& input) const = 0;
};

// The policy of this name. REQUIRES: PolicyNames() (options.h) has it.
std::unique_ptr<Policy> MakePolicy(std::string_view name);

}  // namespace sweepstake::decision
