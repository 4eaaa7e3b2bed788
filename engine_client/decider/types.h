// The plain values of a decision session, besides the ones in sweepstake/frame_sample.h. This code
// reads no clock, does no I/O and starts no thread.
//
// Times are int64_t nanoseconds of the caller's steady clock, whose zero point does not matter.
// They are passed in as `now_ns`. Arms are indices into the session's list of names.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine_client/math/beta_distribution.h"
#include "sweepstake/frame_sample.h"

namespace sweepstake::decision {

// A bit of FrameSample::flags that only the daemon sets. The daemon never accepts it from a client.
// The session reacts to the bail-out but does not store it as evidence, because the client's token
// or address sent too many bail-outs.
inline constexpr uint32_t kFrameNoEvidence = uint32_t{1} << 31;

// Returns whether a value of a SceneDescriptor was measured.
inline bool IsMeasured(float value) { return std::isfinite(value) && value >= 0; }

// The early end of a trial (SwitchCommand). A search over the limit, or an exceeded time budget,
// ends a trial.
struct TrialEnd {
  uint32_t arm = 0;  // the arm that was tried
  // The mean time of its searches (SwitchOutcome).
  uint64_t detection_time_ns = 0;
};

// The cost of an executed switch, measured by the client.
struct SwitchCost {
  uint64_t rebuild_time_ns = 0;   // build time on the frame thread; 0 if built before the switch
  uint64_t settling_cost_ns = 0;  // settling frames: sum of frame time above the settled mean
  // Present if the client ended a trial and switched back by itself. Such a switch has no measured
  // cost.
  std::optional<TrialEnd> ended_trial = {};
};

// Returns the time that the switch took. The settling frames include the rebuild if both are
// present.
inline uint64_t TotalNs(const SwitchCost& cost) {
  return std::max(cost.rebuild_time_ns, cost.settling_cost_ns);
}

inline SwitchCost SwitchCostOf(const SwitchOutcome& outcome) {
  SwitchCost cost = {.rebuild_time_ns = outcome.rebuild_time_ns,
                     .settling_cost_ns = outcome.settling_cost_ns};
  if (outcome.trial_detection_time_ns > 0)
    cost.ended_trial = {.arm = outcome.trial_arm,
                        .detection_time_ns = outcome.trial_detection_time_ns};
  return cost;
}

// The text of each enumeration value, indexed by the value. An empty text marks a number without a
// value.
inline constexpr std::array<std::string_view, 3> kModeNames = {"", "manual", "ai"};
inline constexpr std::array<std::string_view, 5> kSwitchReasonNames = {"", "policy", "exploration",
                                                                       "bail-out", "manual"};

inline constexpr std::array<std::string_view, 10> kOutcomeNames = {
    "",          "kept",   "switched",  "held-cooldown", "held-settling",
    "no-frames", "manual", "exploring", "rejected",      "held-gate"};

inline constexpr std::array<std::string_view, 5> kVerdictNames = {"unknown", "stable", "tie",
                                                                  "ambiguous", "degraded"};

// Returns the text of the value, or its number if it has no text. `value` is an enumeration value
// or a number.
template <typename Enum>
std::string NameOf(std::span<const std::string_view> names, Enum value) {
  const auto number = static_cast<uint32_t>(value);
  const bool is_named = number < names.size() && !names[number].empty();
  return is_named ? std::string(names[number]) : std::to_string(number);
}

// How certain the choice of an arm is.
struct Diagnosis {
  std::vector<double> best_probability;  // one per arm, sum 1; empty before anything is learnt
  uint32_t leader = 0;                   // the arm with the highest best_probability
  double expected_loss_ratio = 0;        // loss of choosing the leader ÷ the best arm's cost
  // The expected loss of choosing the arm with the best mean instead of the arm that is truly the
  // best, as a share of the cost of the best arm.
  double value_remaining_ratio = 0;
  double entropy = 0;  // entropy of best_probability, in nats
  Verdict verdict = Verdict::kUnknown;
};

// The terms of the switch-cost gate for one candidate. The gate passes if horizon_s · gain −
// cooldown_s · loss − cost_s > 0. The difference d is the log-cost of the active arm minus the
// log-cost of the candidate.
struct GateTerms {
  double gain = 0;  // E⁺ = E[max(d, 0)]
  double loss =
      0;  // E⁻ = exp(E[max(−d, 0)]) − 1; at most the budget of a trial (adaptive_policy.h)
  double horizon_s = 0;
  double cooldown_s = 0;
  double cost_s = 0;  // cost of a switch, as measured for earlier ones
};

// The evidence about one arm that a tick or a bail-out adds to the prior store.
struct Increment {
  uint32_t arm = 0;
  double alpha = 0;           // >= 0
  double beta = 0;            // >= 0
  uint32_t window_count = 0;  // windows, or visits of the lane
  uint32_t bail_out_count = 0;
};

// One decision, for the audit log and for watchers.
struct DecisionRecord {
  uint64_t decision_id = 0;  // counts from 1 within the session
  int64_t time_ns = 0;
  uint32_t active_arm = 0;
  std::optional<uint32_t> candidate;  // absent if the policy made no choice
  DecisionOutcome outcome = DecisionOutcome::kKept;
  std::optional<SwitchReason> reason;     // reason of the commanded switch
  std::optional<double> reward;           // absent if there was no window to learn from
  std::vector<double> draws;              // one per arm; empty if nothing was drawn
  std::vector<BetaPosterior> posteriors;  // posteriors after the update
  std::optional<GateTerms> gate;          // absent if the policy has no gate
  double propensity = 1;                  // probability with which the policy draws this candidate
  uint32_t trial_limit_percent = 0;       // for a switch to `candidate` (SwitchCommand)
  Diagnosis diagnosis;
  std::vector<ArmStanding> standings;  // one per arm
  std::optional<double> saved_us;      // DecisionSession::saved_us
};

// Counts of frames and bail-outs since the session began, by how they were treated.
struct SessionCounts {
  uint64_t measured_frame_count = 0;  // frames that a window contains
  // The next four counts are of frames that no window contains.
  uint64_t settling_frame_count = 0;    // frames while settling or warming up
  uint64_t costless_frame_count = 0;    // frames with a flag of kFrameWithoutCost
  uint64_t over_limit_frame_count = 0;  // frames over the bail-out limit
  // Frames of a switch epoch before the active one, or of an arm that does not run in its epoch.
  uint64_t other_epoch_frame_count = 0;
  uint64_t rebuild_frame_count = 0;  // rebuild frames among the measured and settling ones
  // Detection time of these rebuild frames. It saturates at the maximum instead of wrapping.
  uint64_t rebuild_detection_time_ns = 0;
  uint64_t charged_bail_out_count = 0;  // bail-outs that count against an arm
  uint64_t excused_bail_out_count = 0;  // bail-outs that do not
  // Charged bail-outs that are not stored as evidence, because they exceed BailOutBudget
  // (session/safeguards.h) or have kFrameNoEvidence.
  uint64_t surplus_bail_out_count = 0;
};

// The part of the run after the exploration: active time per arm and executed switches. These are
// the paper's "active time" and "post-exploration switches" (§6.2).
class ObservationSummary {
 public:
  std::optional<int64_t> start_ns;  // absent until the exploration ends
  std::vector<uint64_t> active_ns;  // one per arm
  // Executed switches, indexed by SwitchReason. Index 0 counts unknown reasons.
  std::array<uint64_t, 5> switch_counts{};

  uint64_t& switch_count(SwitchReason reason) { return switch_counts[Index(reason)]; }
  uint64_t switch_count(SwitchReason reason) const { return switch_counts[Index(reason)]; }

 private:
  static uint32_t Index(SwitchReason reason) {
    return static_cast<uint32_t>(reason) <= 4 ? static_cast<uint32_t>(reason) : 0;
  }
};

// The result of a tick or a bail-out, which the caller persists, publishes and sends.
struct Decision {
  DecisionRecord record;
  std::optional<Increment> increment;      // from the active arm's window, or from a bail-out
  std::vector<Increment> lane_increments;  // from lane visits since the last tick
  std::string regime;  // the bucket in which the increments are stored (policy/regime_bucket.h)
  std::optional<SwitchCommand> command;
};

}  // namespace sweepstake::decision
