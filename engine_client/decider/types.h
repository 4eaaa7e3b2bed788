// The plain values that go into and come out of the decision core. There is no clock, no I/O and no
// thread here.
//
// Times are int64_t nanoseconds of the caller's steady clock, which may have any origin; they are
// passed in as `now_ns`. Arms are indices into the session's list of names.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine_client/math/beta_distribution.h"

namespace sweepstake::decision {

// The bits of Frame::flags have the values of sweepstake.v1.FrameFlag; the last one is the daemon's
// own and never comes from a client: a bail-out that is answered without being evidence, since
// there were too many of its client's token or address.
enum FrameFlag : uint32_t {
  kFrameRebuild = 1,
  kFramePaused = 2,
  kFrameLoading = 4,
  kFrameBailOut = 8,
  kFrameNoEvidence = uint32_t{1} << 31
};

// The cost of one frame (paper §4: FPS, DET, MEM, CHK).
struct Frame {
  uint64_t frame_time_ns = 0;      // time of the whole frame, unscaled
  uint64_t detection_time_ns = 0;  // time of update and search
  uint64_t aabb_check_count = 0;
  uint64_t native_bytes = 0;
  uint32_t object_count = 0;
  uint32_t arm = 0;
  uint32_t switch_epoch = 0;
  uint32_t flags = 0;
};

// One visit of the shadow lane measures what one arm costs off the frame thread, on copies of the
// boxes of consecutive frames. Visits with the same first_frame_index were measured on the same
// frames and form a sweep, which includes the arm that was active then.
struct ShadowSample {
  uint64_t first_frame_index = 0;
  uint64_t detection_time_ns = 0;  // median of update and search over the measured frames
  uint64_t build_time_ns = 0;      // build and search of the first frame
  uint64_t aabb_check_count = 0;   // mean over the measured frames
  uint64_t native_bytes = 0;
  uint32_t arm = 0;
  uint32_t object_count = 0;
  uint32_t frame_count = 0;  // measured frames; the build and the warm-up are not counted
  uint32_t flags = 0;        // bits of ShadowFlag
};

// The bits of ShadowSample::flags have the values of sweepstake.v1.ShadowFlag.
enum ShadowFlag : uint32_t {
  kShadowActive = 1,  // the arm was active on the frame thread
  kShadowCapped = 2,  // a cap of the lane ended the visit; the times cover what ran until then
};

// The properties of the scene that matter to a broad phase (sweepstake.v1.SceneDescriptor). A value
// that was not measured is absent.
struct SceneDescriptor {
  std::optional<double> object_count;
  std::optional<double> density_ratio;
  std::optional<double> size_spread;
  std::optional<double> speed_mean;
  std::optional<double> speed_spread;
  std::optional<double> clustering_ratio;
  std::optional<double> static_ratio;
};

// What has ended a trial (SwitchCommand): two frames, of which this is the shorter one, or all of
// them, of which it is at most the mean. The arm may cost more, and was not let.
struct TrialEnd {
  uint32_t arm = 0;  // the arm that was tried
  uint64_t detection_time_ns = 0;
};

// The cost of an executed switch, as the client measured it.
struct SwitchCost {
  uint64_t rebuild_time_ns = 0;   // time of a build on the frame thread; 0 if it was built before
  uint64_t settling_cost_ns = 0;  // sum of the settling frames' time above the settled mean
  std::optional<TrialEnd> ended_trial = {};  // with the client's own way back; it has no cost yet
};

enum class Mode : uint32_t { kManual = 1, kAi = 2 };
enum class SwitchReason : uint32_t { kPolicy = 1, kExploration = 2, kBailOut = 3, kManual = 4 };

// The words of an enumeration by value; an empty word means that there is no such value.
inline constexpr std::array<std::string_view, 3> kModeNames = {"", "manual", "ai"};
inline constexpr std::array<std::string_view, 5> kSwitchReasonNames = {"", "policy", "exploration",
                                                                       "bail-out", "manual"};

// The outcome of a tick's candidate. The values are those of sweepstake.v1.DecisionOutcome; 10 and
// 11 were used by older versions and must not be reused.
enum class Outcome : uint32_t {
  kKept = 1,
  kSwitched = 2,
  kHeldCooldown = 3,
  kHeldSettling = 4,  // all frames were settling ones, or a commanded switch is under way
  kNoFrames = 5,      // no frame to learn from has arrived since the last tick
  kManual = 6,
  kExploring = 7,  // there is no candidate; a command, if any, names the next arm of the order
  kRejected = 8,   // a metric of the window is not finite
  kHeldGate = 9,   // the expected gain does not pay for the switch
  kHeldTie = 12,   // the expected gain is too small to matter
};
inline constexpr std::array<std::string_view, 13> kOutcomeNames = {
    "",          "kept",   "switched",  "held-cooldown", "held-settling",
    "no-frames", "manual", "exploring", "rejected",      "held-gate",
    "",          "",       "held-tie"};

// What the posteriors say about the scene (paper §7.1 uses posteriors as a diagnosis).
enum class Verdict : uint32_t {
  kUnknown = 0,    // nothing is decided yet
  kStable = 1,     // P(best) of the leader is 0.8 or more
  kTie = 2,        // P(best) is lower, and choosing the leader loses 0.5 % or less
  kAmbiguous = 3,  // P(best) is lower, and choosing the leader may lose more
  kDegraded = 4,   // even the leader misses the frame-rate floor
};
inline constexpr std::array<std::string_view, 5> kVerdictNames = {"unknown", "stable", "tie",
                                                                  "ambiguous", "degraded"};

// How certain the choice of an arm is.
struct Diagnosis {
  std::vector<double> best_probability;  // has one per arm, sum 1; empty while nothing is learnt
  uint32_t leader = 0;                   // the arm with the highest best_probability
  double expected_loss_ratio = 0;        // loss of choosing the leader ÷ the best arm's cost
  // What perfect information would gain over choosing the arm with the best mean, on the same
  // scale.
  double value_remaining_ratio = 0;
  double entropy = 0;  // entropy of best_probability, in nats
  Verdict verdict = Verdict::kUnknown;
};

// A cost ÷ another one, of which it is believed to have this median, and to be from low to high
// with a probability of 95 %.
struct CostRatio {
  double median = 1;
  double low = 1;
  double high = 1;
  bool operator==(const CostRatio&) const = default;
};

// What a session has measured of an arm, and what follows from it in units that people read.
struct ArmStanding {
  uint64_t live_window_count = 0;  // windows learnt
  uint64_t lane_visit_count = 0;   // visits of the shadow lane learnt
  // The number of live windows, of an arm that does not change, that would leave a posterior of
  // this width; priors and visits count for what they tell, and so may windows for less than one.
  double effective_window_count = 0;
  // Cost ÷ the leader's; absent while nothing is learnt, and where rewards do not tell costs
  // (log_cost.h).
  std::optional<CostRatio> cost_ratio;
};

// The terms of the switch-cost gate for the candidate, which passes if
// horizon_s · gain − cooldown_s · loss − cost_s > 0. The difference d is the log-cost of the active
// arm minus that of the candidate.
struct GateTerms {
  double gain = 0;  // E⁺ = E[max(d, 0)]
  double loss = 0;  // E⁻ = E[max(−d, 0)]; of a trial at most what its budget allows
  double horizon_s = 0;
  double cooldown_s = 0;
  double cost_s = 0;  // measured cost of the switch
};

struct SwitchCommand {
  uint64_t command_id = 0;  // counts from 1 within the session
  uint32_t arm = 0;
  SwitchReason reason = SwitchReason::kPolicy;
  // A trial: the client goes back by itself if the new arm makes frames longer than this share of
  // the longest ones before the switch, in percent, or has spent the trial's budget. 0: no trial.
  uint32_t trial_limit_percent = 0;
};

// The evidence about one arm that a tick or a bail-out adds, as it is stored.
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
  std::optional<uint32_t> candidate;  // absent if the policy was not asked
  Outcome outcome = Outcome::kKept;
  std::optional<SwitchReason> reason;     // reason of the commanded switch
  std::optional<double> reward;           // absent if there was no window to learn from
  std::vector<double> draws;              // has one per arm; empty if nothing was drawn
  std::vector<BetaPosterior> posteriors;  // posteriors after the update
  std::optional<GateTerms> gate;          // absent if the policy has no gate
  double propensity = 1;                  // probability with which the policy draws this candidate
  uint32_t trial_limit_percent = 0;       // of a switch to the candidate (SwitchCommand)
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
  std::optional<Increment> increment;      // of the frame thread's window, or of a bail-out
  std::vector<Increment> lane_increments;  // of the lane's visits since the last tick
  std::optional<SwitchCommand> command;
};

}  // namespace sweepstake::decision
