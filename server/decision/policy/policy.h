// What every way of deciding has in common: it learns from what the session measured, says what it
// believes, and chooses.
//
// One object per session; not thread-safe. Learning changes it, choosing does not. All randomness
// comes from seed and decision_id, so that the same calls give the same choices. Memory is bounded
// by the number of arms. Cooldown, settling, bail-outs and exploration are the session's
// (decision_session.h).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/decision/options.h"
#include "server/decision/types.h"
#include "server/decision/window.h"

namespace sweepstake::decision {

struct WindowObservation {
  uint32_t arm = 0;
  const Window& window;  // settled frames since the last tick, at least one
  int64_t now_ns = 0;
};

// What a window taught.
struct Lesson {
  Increment increment;  // to be made durable
  double reward = 0;    // 0–1
};

struct ChoiceInput {
  uint32_t active_arm = 0;
  uint64_t seed = 0;
  uint64_t decision_id = 0;  // with the seed, all the randomness there is
  int64_t now_ns = 0;
  int64_t last_tick_ns = 0;               // start_ns where there was none yet
  std::optional<int64_t> last_switch_ns;  // executed, of any reason; absent: none yet
  int64_t start_ns = 0;                   // of the session
  bool bailed_out = false;  // asked at once, outside the ticks, since the active arm was blamed
};

struct Choice {
  uint32_t candidate = 0;
  std::vector<double> draws;    // one per arm, as the policy compared them; empty: no draws
  std::optional<Outcome> hold;  // why the policy itself would not switch to the candidate now
  std::optional<GateTerms> gate;
  double propensity = 1;
};

class Policy {
 public:
  virtual ~Policy() = default;

  // Absent, and nothing changed, where a metric is not finite.
  virtual std::optional<Lesson> LearnWindow(const WindowObservation& observation) = 0;
  virtual Increment LearnBailOut(uint32_t arm) = 0;
  // Of the tick under way, before its window. Ignored by policies that know only live windows.
  virtual void LearnShadow(std::span<const ShadowSample> /*samples*/, int64_t /*now_ns*/) {}
  virtual void LearnDescriptor(const SceneDescriptor& /*descriptor*/, int64_t /*now_ns*/) {}
  virtual void LearnSwitchCost(uint32_t /*arm*/, const SwitchCost& /*cost*/) {}

  virtual Choice Choose(const ChoiceInput& input) const = 0;
  // Least time between two switches; absent: the options'.
  virtual std::optional<int64_t> cooldown_ns() const { return std::nullopt; }

  // One per arm.
  virtual const std::vector<BetaPosterior>& posteriors() const = 0;
  // Name of the context the beliefs are about; empty: the only one.
  virtual std::string context() const { return {}; }
  // How sure it is; the verdict's part that needs the frame rate is the session's. By default from
  // the posteriors as they are (diagnosis.h).
  virtual Diagnosis Diagnose() const;
};

// What is known of a policy before one is made.
struct PolicyKind {
  std::string_view name;
  uint32_t reward_version = 1;      // evidence of different versions is never merged
  bool explores = true;             // begins with the live exploration of all arms (paper §6.3)
  bool starts_from_priors = false;  // where there are priors, decides before the first frame
  bool uses_shadow = false;         // learns from the shadow lane
};

// REQUIRES: PolicyNames() (options.h) has it, or it is "default".
const PolicyKind& PolicyKindOf(std::string_view name);

struct PolicySetup {
  DecisionOptions options;
  std::vector<std::string> arms;
  std::vector<BetaPosterior> priors;  // one per arm
  bool has_priors = false;            // false: they are all Beta(1,1) for want of anything known
};

// The policy of setup.options.policy. REQUIRES: Validate(setup.options) is content.
std::unique_ptr<Policy> MakePolicy(const PolicySetup& setup);

}  // namespace sweepstake::decision
