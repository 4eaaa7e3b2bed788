// What goes into and comes out of the decision core. Plain values; no clock, no I/O, no threads.
//
// Times are int64_t nanoseconds of the caller's steady clock, from any origin, passed in as
// `now_ns`. Arms are indices into the session's list of names.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/decision/math/beta_distribution.h"

namespace sweepstake::decision {

// Bits of Frame::flags; the values of sweepstake.v1.FrameFlag.
enum FrameFlag : uint32_t {
  kFrameRebuild = 1,
  kFramePaused = 2,
  kFrameLoading = 4,
  kFrameBailOut = 8
};

// What one frame cost (paper §4: FPS, DET, MEM, CHK).
struct Frame {
  uint64_t frame_time_ns = 0;      // unscaled, whole frame
  uint64_t detection_time_ns = 0;  // update and search
  uint64_t aabb_check_count = 0;
  uint64_t native_bytes = 0;
  uint32_t object_count = 0;
  uint32_t arm = 0;
  uint32_t switch_epoch = 0;
  uint32_t flags = 0;
};

// One visit of the shadow lane: what an arm cost off the frame thread, on copies of consecutive
// frames' boxes. Visits with the same first_frame_index were measured on the same frames and form a
// sweep; the arm that was active then is measured along with the others.
struct ShadowSample {
  uint64_t first_frame_index = 0;
  uint64_t detection_time_ns = 0;  // median over the measured frames: update and search
  uint64_t build_time_ns = 0;     // of the first frame, which builds the structure, with its search
  uint64_t aabb_check_count = 0;  // mean over the measured frames
  uint64_t native_bytes = 0;
  uint32_t arm = 0;
  uint32_t object_count = 0;
  uint32_t frame_count = 0;  // measured frames, without the build and the warm-up after it
  uint32_t flags = 0;        // bits of ShadowFlag
};

// Bits of ShadowSample::flags; the values of sweepstake.v1.ShadowFlag.
enum ShadowFlag : uint32_t {
  kShadowActive = 1,  // the arm that was active on the frame thread
  kShadowCapped = 2,  // stopped at the lane's time cap: the times are those of what ran until then
};

// What the scene looks like to a broad phase (sweepstake.v1.SceneDescriptor); absent: not measured.
struct SceneDescriptor {
  std::optional<double> object_count;
  std::optional<double> density_ratio;
  std::optional<double> size_spread;
  std::optional<double> speed_mean;
  std::optional<double> speed_spread;
  std::optional<double> clustering_ratio;
  std::optional<double> static_ratio;
};

// What an executed switch cost, as the client measured it.
struct SwitchCost {
  uint64_t rebuild_time_ns = 0;   // building the structure on the frame thread; 0: built beforehand
  uint64_t settling_cost_ns = 0;  // frame time above the settled mean, over the settling frames
};

enum class Mode : uint32_t { kManual = 1, kAi = 2 };
enum class SwitchReason : uint32_t { kPolicy = 1, kExploration = 2, kBailOut = 3, kManual = 4 };

// What became of a tick's candidate; the values of sweepstake.v1.DecisionOutcome.
// 10 and 11 are retired and stay unused.
enum class Outcome : uint32_t {
  kKept = 1,
  kSwitched = 2,
  kHeldCooldown = 3,
  kHeldSettling = 4,  // settling frames only, nothing learnt; or a commanded switch is under way
  kNoFrames = 5,      // none to learn from since the last tick
  kManual = 6,
  kExploring = 7,  // no candidate; a command there may be goes to the next arm of the order
  kRejected = 8,   // a metric of the window is not finite
  kHeldGate = 9,   // the gain expected is not worth the switch
  kHeldTie = 12,   // the candidate is not better by as much as matters
};

// What the beliefs say about the scene (paper §7.1: posteriors as a diagnosis).
enum class Verdict : uint32_t {
  kUnknown = 0,    // nothing learnt yet
  kStable = 1,     // P(best) of the leader is 0.8 or more
  kTie = 2,        // below, and choosing the leader loses 0.5 % or less
  kAmbiguous = 3,  // below, and it may lose more
  kDegraded = 4,   // even the leader misses the frame-rate floor
};

// How sure one is of the choice.
struct Diagnosis {
  std::vector<double> best_probability;  // per arm, sum 1; empty: nothing learnt yet
  uint32_t leader = 0;                   // the arm with the highest
  double expected_loss_ratio = 0;        // of choosing the leader, relative to the best arm's cost
  // What knowing all would gain over choosing the arm with the best mean, in the same terms.
  double value_remaining_ratio = 0;
  double entropy = 0;  // of best_probability, in nats
  Verdict verdict = Verdict::kUnknown;
};

// The terms of the switch-cost gate for the candidate: it passes where
// horizon_s · gain − cooldown_s · loss − cost_s > 0.
struct GateTerms {
  double gain = 0;  // E⁺ = E[max(d, 0)] of d, the log-cost of the active arm minus the candidate's
  double loss = 0;  // E⁻ = E[max(−d, 0)]
  double horizon_s = 0;
  double cooldown_s = 0;
  double cost_s = 0;  // of the switch, measured
};

struct SwitchCommand {
  uint64_t command_id = 0;  // from 1 within the session
  uint32_t arm = 0;
  SwitchReason reason = SwitchReason::kPolicy;
};

// What a tick or a bail-out taught about one arm, to be made durable.
struct Increment {
  uint32_t arm = 0;
  double alpha = 0;  // >= 0
  double beta = 0;   // >= 0
  uint32_t window_count = 0;
  uint32_t bail_out_count = 0;
};

// One decision, for the audit log and for watchers.
struct DecisionRecord {
  uint64_t decision_id = 0;  // from 1 within the session
  int64_t time_ns = 0;
  uint32_t active_arm = 0;
  std::optional<uint32_t> candidate;  // highest draw; absent where none was drawn
  Outcome outcome = Outcome::kKept;
  std::optional<SwitchReason> reason;     // of the commanded switch
  std::optional<double> reward;           // absent where the window taught nothing
  std::vector<double> draws;              // one per arm; empty where none was drawn
  std::vector<BetaPosterior> posteriors;  // after the update
  std::string context;                    // bucket of the scene's descriptors; empty: none
  std::optional<GateTerms> gate;          // absent where the policy has no gate
  double propensity = 1;                  // probability with which the policy draws this candidate
  Diagnosis diagnosis;
};

// Frames and bail-outs by what became of them, since the session began.
struct SessionCounts {
  uint64_t measured_frame_count = 0;    // in a window
  uint64_t settling_frame_count = 0;    // left out: settling or warming up
  uint64_t suspended_frame_count = 0;   // left out: paused or loading
  uint64_t over_limit_frame_count = 0;  // left out: over the bail-out limit
  uint64_t other_epoch_frame_count =
      0;  // left out: of an earlier switch epoch or of an arm that is not active in it
  uint64_t rebuild_frame_count = 0;  // of the measured and settling ones, those that rebuilt
  uint64_t rebuild_detection_time_ns =
      0;  // what these cost; stays at the largest value rather than wrap
  uint64_t charged_bail_out_count = 0;  // blamed on an arm
  uint64_t excused_bail_out_count = 0;  // recorded, not blamed
};

// The run since the exploration ended: the paper's active time and post-exploration switches
// (§6.2).
class ObservationSummary {
 public:
  std::optional<int64_t> start_ns;  // absent: the exploration goes on
  std::vector<uint64_t> active_ns;  // per arm
  std::array<uint64_t, 5>
      switch_counts{};  // executed, by the value of SwitchReason; 0: any other value

  uint64_t& switch_count(SwitchReason reason) { return switch_counts[Index(reason)]; }
  uint64_t switch_count(SwitchReason reason) const { return switch_counts[Index(reason)]; }

 private:
  static uint32_t Index(SwitchReason reason) {
    return static_cast<uint32_t>(reason) <= 4 ? static_cast<uint32_t>(reason) : 0;
  }
};

// What a tick or a bail-out asks the caller to do: persist, publish, send.
struct Decision {
  DecisionRecord record;
  std::optional<Increment> increment;
  std::optional<SwitchCommand> command;
};

}  // namespace sweepstake::decision
