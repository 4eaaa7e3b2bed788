// The interface of every policy. A policy learns from what the session measures, reports its
// beliefs, and chooses an arm.
//
// Each session has its own policy object, which is not thread-safe. Learning changes the object,
// choosing does not. All randomness comes from seed and decision_id, so the same calls give the
// same choices. Memory is bounded by the number of arms. Cooldown, settling, bail-outs and
// exploration are rules of the session (session/decision_session.h).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine_client/decider/options.h"
#include "engine_client/decider/policy/log_cost.h"
#include "engine_client/decider/policy/regime_bucket.h"
#include "engine_client/decider/policy/regime_report.h"
#include "engine_client/decider/regime_span.h"
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
  uint64_t decision_id = 0;  // seed and decision_id are the only source of randomness
  int64_t now_ns = 0;
  int64_t last_tick_ns = 0;               // before the first tick: start_ns
  std::optional<int64_t> last_switch_ns;  // latest executed switch, for any reason; absent: none
  int64_t start_ns = 0;                   // the session's start
  bool bailed_out = false;  // the choice follows a bail-out of the active arm, not a tick
};

struct Choice {
  uint32_t candidate = 0;
  std::vector<double> draws;            // the values that were compared, one per arm; may be empty
  std::optional<DecisionOutcome> hold;  // why the policy holds this switch back
  std::optional<GateTerms> gate;
  double propensity = 1;             // unused for a draw of Thompson sampling (PolicyKind)
  uint32_t trial_limit_percent = 0;  // trial limit of the switch (SwitchCommand)
};

class Policy {
 public:
  virtual ~Policy() = default;

  // Learns from a window. If a metric is not finite, it changes nothing and returns nothing.
  virtual std::optional<WindowUpdate> LearnWindow(const WindowObservation& observation) = 0;
  virtual Increment LearnBailOut(uint32_t arm) = 0;
  // A policy that learns only from live windows leaves the following functions empty. In a tick,
  // the session calls LearnDescriptor, LearnShadow and LearnWindow in this order. If the regime has
  // ended, it calls LearnDescriptor last, because the evidence belongs to the regime before.
  //
  // Learns from visits of the lane. Returns their evidence, which the session stores.
  virtual std::vector<Increment> LearnShadow(std::span<const ShadowSample> /*samples*/,
                                             int64_t /*now_ns*/) {
    return {};
  }
  // Returns which regime the descriptor matches. Called only if PolicyKind::keeps_regimes.
  virtual DescriptorMatch Match(const SceneDescriptor& /*descriptor*/) const {
    return DescriptorMatch::kPresent;
  }
  // Learns from a descriptor, and makes its regime the present one. A descriptor that matches no
  // known regime begins a new one.
  virtual void LearnDescriptor(const SceneDescriptor& /*descriptor*/, int64_t /*now_ns*/) {}
  virtual void LearnSwitchCost(uint32_t /*arm*/, const SwitchCost& /*cost*/) {}
  // Learns that a trial of an arm ended early, and that the client returned to `arm_before`.
  virtual void LearnTrialEnd(const TrialEnd& /*end*/, uint32_t /*arm_before*/, int64_t /*now_ns*/) {
  }

  virtual Choice Choose(const ChoiceInput& input) const = 0;
  // Minimum time between two switches. Absent: the cooldown of the options.
  virtual std::optional<int64_t> cooldown_ns() const { return std::nullopt; }

  // Returns one posterior per arm.
  virtual const std::vector<BetaPosterior>& posteriors() const = 0;
  // Returns by how much one live window of the arm raises α + β.
  virtual double WindowEvidence(uint32_t /*arm*/) const { return 1; }
  // Returns how certain the policy is. The default is computed from the posteriors (diagnosis.h).
  // The session adds the verdict kDegraded, which depends on frame times.
  virtual Diagnosis Diagnose() const;

  // Returns the features of the present regime. They determine where its evidence is stored.
  virtual RegimeFeatures present_features() const { return FeaturesOf({}); }

  // The following functions are for reports (regime_report.h). A policy without regimes has one.
  virtual RegimeId present_regime() const { return {}; }
  virtual std::vector<RegimeBelief> Regimes() const { return {{.is_present = true}}; }
  // Returns the expected log-cost of an arm in the present regime. Absent if it is not known.
  virtual std::optional<double> ExpectedLogCost(uint32_t /*arm*/) const { return std::nullopt; }
};

// The properties of a policy that are known before a policy object exists.
struct PolicyKind {
  std::string_view name;
  uint32_t reward_version = 1;      // evidence of different versions is never merged
  bool explores = true;             // begins with the live exploration of all arms (paper §6.3)
  bool starts_from_priors = false;  // if it has priors, decides before the first frame
  bool uses_shadow = false;         // learns from the shadow lane
  bool keeps_regimes = false;       // learns each regime of the scene apart (regime_span.h)
  // Thompson sampling: a choice with draws takes the highest of one draw from each posterior. The
  // session computes its propensity, which is the candidate's probability of being the best.
  bool draws_from_posteriors = false;
  // true: every frame over the bail-out limit counts against the active arm, whatever took the
  // time, as in the paper (§4). false: IsCausedByArm in session/safeguards.h decides.
  bool counts_any_cause = false;

  // Returns whether the rewards depend on the detection time alone, and not on RewardWeights.
  bool goes_by_cost() const { return reward_version == kLogCostRewardVersion; }
};

// Returns the options with the times that a policy of this kind uses
// (DecisionOptions::regime_interval_ns).
DecisionOptions OptionsFor(const PolicyKind& kind, DecisionOptions options);

struct PolicySetup {
  DecisionOptions options;
  std::vector<std::string> arms;
  std::vector<BetaPosterior> priors;  // one per arm
  RegimePriors regime_priors = {};
  bool has_priors = false;   // false: no prior is known, so all are Beta(1,1)
  bool stops_trials = true;  // the game bounds the cost of a trial (SwitchCommand)
};

// Returns the choice of the arm with the highest draw; the first one if several have it. REQUIRES:
// not empty, no NaN.
Choice HighestOf(std::vector<double> draws);

// Returns the probability with which Thompson sampling draws this arm: that of being the best,
// which `diagnosis` has. It is above 0, because the arm was drawn. Without a diagnosis nothing was
// learnt, and all arms have the same probability.
double PropensityOfDraw(const Diagnosis& diagnosis, uint32_t arm, size_t arm_count);

// Returns a choice of this arm that contains no draws.
Choice ChoiceOf(uint32_t arm);

// For policies that choose once per cooldown. (The paper's policy draws at every tick.) Returns
// true
// - at the first tick after each whole cooldown since the last switch; before the first switch,
//   cooldowns count from the session's start
// - at the session's first tick
// - after a bail-out
// If settling or missing frames hold a choice back, the next one comes a whole cooldown later.
bool IsTimeToChoose(const ChoiceInput& input, int64_t cooldown_ns);

}  // namespace sweepstake::decision
