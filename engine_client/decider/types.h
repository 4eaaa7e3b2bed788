// The plain values of a decision session beside those of sweepstake/frame_sample.h. There is no
// clock, I/O or thread here.
//
// Times are int64_t nanoseconds of the caller's steady clock, which may have any origin; they are
// passed in as `now_ns`. Arms are indices into the session's list of names.
#pragma once

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

// A bit of FrameSample::flags that the daemon sets itself and never accepts from a client: the
// bail-out is answered but is not evidence, because its client's token or address sent too many.
inline constexpr uint32_t kFrameNoEvidence = uint32_t{1} << 31;

// Returns whether a value of a SceneDescriptor was measured.
inline bool IsMeasured(float value) { return std::isfinite(value) && value >= 0; }

// The early end of a trial (SwitchCommand). detection_time_ns is the shorter one of the two frames
// that ended it, or at most the mean of all frames. It is a lower bound of the arm's cost.
struct TrialEnd {
  uint32_t arm = 0;  // the arm that was tried
  uint64_t detection_time_ns = 0;
};

// The cost of an executed switch, as the client measured it.
struct SwitchCost {
  uint64_t rebuild_time_ns = 0;   // time of a build on the frame thread; 0 if it was built before
  uint64_t settling_cost_ns = 0;  // sum of the settling frames' time above the settled mean
  // present if the client itself switched back; the switch has no cost yet
  std::optional<TrialEnd> ended_trial = {};
};

inline SwitchCost SwitchCostOf(const SwitchOutcome& outcome) {
  SwitchCost cost = {.rebuild_time_ns = outcome.rebuild_time_ns,
                     .settling_cost_ns = outcome.settling_cost_ns};
  if (outcome.trial_detection_time_ns > 0)
    cost.ended_trial = {.arm = outcome.trial_arm,
                        .detection_time_ns = outcome.trial_detection_time_ns};
  return cost;
}

// Words of an enumeration by value. An empty word means that the value does not exist.
inline constexpr std::array<std::string_view, 3> kModeNames = {"", "manual", "ai"};
inline constexpr std::array<std::string_view, 5> kSwitchReasonNames = {"", "policy", "exploration",
                                                                       "bail-out", "manual"};

inline constexpr std::array<std::string_view, 11> kOutcomeNames = {
    "",       "kept",      "switched", "held-cooldown", "held-settling", "no-frames",
    "manual", "exploring", "rejected", "held-gate",     "held-tie"};

inline constexpr std::array<std::string_view, 5> kVerdictNames = {"unknown", "stable", "tie",
                                                                  "ambiguous", "degraded"};

// Returns the value's word, or its number if it has none. The value may be of an enumeration or a
// number.
template <typename Enum>
std::string NameOf(std::span<const std::string_view> names, Enum value) {
  const auto number = static_cast<uint32_t>(value);
  const bool is_named = number < names.size() && !names[number].empty();
  return is_named ? std::string(names[number]) : std::to_string(number);
}

// How certain the choice of an arm is.
struct Diagnosis {
  std::vector<double> best_probability;  // has one per arm, sum 1; empty while nothing is learnt
  uint32_t leader = 0;                   // the arm with the highest best_probability
  double expected_loss_ratio = 0;        // loss of choosing the leader ÷ the best arm's cost
  // The gain of perfect information over choosing the arm with the best mean, on the same scale.
  double value_remaining_ratio = 0;
  double entropy = 0;  // entropy of best_probability, in nats
  Verdict verdict = Verdict::kUnknown;
};

// The terms of the switch-cost gate for the candidate, which passes if horizon_s · gain −
// cooldown_s · loss − cost_s > 0. The difference d is the log-cost of the active arm minus that of
// the candidate.
struct GateTerms {
  double gain = 0;  // E⁺ = E[max(d, 0)]
  double loss = 0;  // E⁻ = E[max(−d, 0)]; for a trial, limited by its budget
  double horizon_s = 0;
  double cooldown_s = 0;
  double cost_s = 0;  // measured cost of the switch
};

// The evidence about one arm that a tick or a bail-out adds to the store.
struct Increment {
  uint32_t arm = 0;
  double alpha = 0;           // >= 0
  double beta = 0;            // >= 0
  uint32_t window_count = 0;  // windows, or the lane's visits
  uint32_t bail_out_count = 0;
};

// One decision, for the audit log and for watchers.
struct DecisionRecord {
  uint64_t decision_id = 0;  // counts from 1 within the session
  int64_t time_ns = 0;
  uint32_t active_arm = 0;
  std::optional<uint32_t> candidate;  // absent if the policy did not choose
  DecisionOutcome outcome = DecisionOutcome::kKept;
  std::optional<SwitchReason> reason;     // reason of the commanded switch
  std::optional<double> reward;           // absent if there was no window to learn from
  std::vector<double> draws;              // has one per arm; empty if nothing was drawn
  std::vector<BetaPosterior> posteriors;  // posteriors after the update
  std::optional<GateTerms> gate;          // absent if the policy has no gate
  double propensity = 1;                  // probability with which the policy draws this candidate
  uint32_t trial_limit_percent = 0;       // trial limit of a switch to it (SwitchCommand)
  Diagnosis diagnosis;
  std::vector<ArmStanding> standings;  // has one per arm
};

// Counts of frames and bail-outs since the session began, by how they were treated.
struct SessionCounts {
  uint64_t measured_frame_count = 0;  // frames that a window contains
  // The next four counts are of frames that no window contains.
  uint64_t settling_frame_count = 0;    // frames while settling or warming up
  uint64_t suspended_frame_count = 0;   // frames while paused or loading
  uint64_t over_limit_frame_count = 0;  // frames over the bail-out limit
  // Frames of an earlier switch epoch, or of an arm that is not active in its epoch.
  uint64_t other_epoch_frame_count = 0;
  uint64_t rebuild_frame_count = 0;  // measured and settling frames that rebuilt
  // Detection time of these rebuild frames. It saturates at the maximum instead of wrapping.
  uint64_t rebuild_detection_time_ns = 0;
  uint64_t charged_bail_out_count = 0;  // bail-outs blamed on an arm
  uint64_t excused_bail_out_count = 0;  // bail-outs recorded without blame
  // Charged bail-outs beyond the budget (session/safeguards.h), which are no evidence.
  uint64_t surplus_bail_out_count = 0;
};

// The run since the exploration ended, in the paper's terms: active time and post-exploration
// switches (§6.2).
class ObservationSummary {
 public:
  std::optional<int64_t> start_ns;  // absent while the exploration goes on
  std::vector<uint64_t> active_ns;  // has one per arm
  // Executed switches by the value of SwitchReason; index 0 counts every other value.
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
  std::optional<Increment> increment;      // from the frame thread's window or a bail-out
  std::vector<Increment> lane_increments;  // from the lane's visits since the last tick
  std::optional<SwitchCommand> command;
};

}  // namespace sweepstake::decision
