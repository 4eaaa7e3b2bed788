// The interface of every policy: it learns from what the session measured, reports what it
// believes, and chooses an arm.
//
// There is one object per session; it is not thread-safe. Learning changes it, choosing does not.
// All randomness comes from seed and decision_id, so that the same calls give the same choices. The
// memory is bounded by the number of arms. Cooldown, settling, bail-outs and exploration belong to
// the session (session/decision_session.h).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine_client/decider/options.h"
#include "engine_client/decider/types.h"
#include "engine_client/decider/window.h"

namespace sweepstake::decision {

struct WindowObservation {
  uint32_t arm = 0;
  const Window& window;  // settled frames since the last tick, at least one
  int64_t now_ns = 0;
};

// The result of learning from a window.
struct WindowUpdate {
  Increment increment;  // evidence to be stored
  double reward = 0;    // 0–1
};

struct ChoiceInput {
  uint32_t active_arm = 0;
  uint64_t seed = 0;
  uint64_t decision_id = 0;  // together with the seed the only source of randomness
  int64_t now_ns = 0;
  int64_t last_tick_ns = 0;               // start_ns before the first tick
  std::optional<int64_t> last_switch_ns;  // executed, for any reason; absent if there was none
  int64_t start_ns = 0;                   // the session's start
  bool bailed_out = false;  // a choice between ticks, after a bail-out blamed on the active arm
};

struct Choice {
  uint32_t candidate = 0;
  std::vector<double> draws;            // the values the policy compared, one per arm; may be empty
  std::optional<DecisionOutcome> hold;  // why the policy itself does not want the switch now
  std::optional<GateTerms> gate;
  double propensity = 1;
  uint32_t trial_limit_percent = 0;  // trial limit of the switch (SwitchCommand)
};

class Policy {
 public:
  virtual ~Policy() = default;

  // Changes nothing and returns nothing if a metric is not finite.
  virtual std::optional<WindowUpdate> LearnWindow(const WindowObservation& observation) = 0;
  virtual Increment LearnBailOut(uint32_t arm) = 0;
  // These are called before the window of the same tick. Policies that learn from live windows
  // only ignore them.
  // Returns the visits' evidence, which is to be stored.
  virtual std::vector<Increment> LearnShadow(std::span<const ShadowSample> /*samples*/,
                                             int64_t /*now_ns*/) {
    return {};
  }
  virtual void LearnDescriptor(const SceneDescriptor& /*descriptor*/, int64_t /*now_ns*/) {}
  virtual void LearnSwitchCost(uint32_t /*arm*/, const SwitchCost& /*cost*/) {}
  // `end` is a lower bound of the cost of the arm that was tried.
  virtual void LearnTrialEnd(const TrialEnd& /*end*/, int64_t /*now_ns*/) {}

  virtual Choice Choose(const ChoiceInput& input) const = 0;
  // Minimum time between two switches; if absent, that of the options.
  virtual std::optional<int64_t> cooldown_ns() const { return std::nullopt; }

  // Returns one posterior per arm.
  virtual const std::vector<BetaPosterior>& posteriors() const = 0;
  // Returns what one live window of the arm adds to α + β.
  virtual double WindowEvidence(uint32_t /*arm*/) const { return 1; }
  // How certain the policy is, by default computed from the posteriors (diagnosis.h). The session
  // adds the verdict kDegraded, which needs the frame rate.
  virtual Diagnosis Diagnose() const;
};

// The properties of a policy that are known before it is made.
struct PolicyKind {
  std::string_view name;
  uint32_t reward_version = 1;      // evidence of different versions is never merged
  bool explores = true;             // begins with the live exploration of all arms (paper §6.3)
  bool starts_from_priors = false;  // decides before the first frame if it has priors
  bool uses_shadow = false;         // learns from the shadow lane
  // A frame over the bail-out limit is always blamed on the active arm, whatever took the time, as
  // in the paper (§4). Otherwise BlamesArm in session/safeguards.h decides.
  bool blames_any_cause = false;
};

struct PolicySetup {
  DecisionOptions options;
  std::vector<std::string> arms;
  std::vector<BetaPosterior> priors;  // has one per arm
  bool has_priors = false;            // false: all priors are Beta(1,1) because none are known
};

// Returns the arm with the highest number, the first one of equals. REQUIRES: not empty, no NaN.
Choice HighestOf(std::vector<double> draws);

// Returns the choice of this arm without any draw.
Choice ChoiceOf(uint32_t arm);

// For policies that choose once per cooldown, where the paper draws at every tick until a draw
// leaves the arm. Returns true at the first tick after each whole cooldown since the last switch,
// and always after a bail-out. Before the first switch the cooldowns count from the session's
// start, and its first tick returns true as well. If the session holds a choice back because of
// settling or missing frames, the next choice still comes a cooldown later.
bool IsTimeToChoose(const ChoiceInput& input, int64_t cooldown_ns);

}  // namespace sweepstake::decision
