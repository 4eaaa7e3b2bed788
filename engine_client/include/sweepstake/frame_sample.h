// The cost of one frame (paper §4: FPS, DET, MEM, CHK, and the context of these). Plain data.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <type_traits>

namespace sweepstake {

// Bits of FrameSample::flags; the same values as sweepstake.v1.FrameFlag.
enum FrameFlag : uint32_t {
  kFrameRebuild = 1,  // the backend's structure was rebuilt
  kFramePaused = 2,   // the game was paused or in the background
  kFrameLoading = 4,  // a scene was loading
  kFrameBailOut = 8,  // over the bail-out limit
};

// A frame may search several times, once per substep. Its times and checks are then the sums; the
// counts of bytes, pairs and objects are those of its latest search.
struct FrameSample {
  uint64_t frame_index;        // since the session began
  uint64_t frame_time_ns;      // unscaled, whole frame
  uint64_t detection_time_ns;  // Build or Update plus FindPairs; 0 without a search
  uint64_t aabb_check_count;
  uint64_t native_bytes;
  uint32_t pair_count;
  uint32_t object_count;
  uint32_t arm;           // index in the session's list of arms
  uint32_t switch_epoch;  // executed switches before this frame
  uint32_t flags;         // FrameFlag bits
  uint32_t reserved;      // 0
};
static_assert(sizeof(FrameSample) == 64);
static_assert(std::is_trivially_copyable_v<FrameSample>);

// The properties of a scene that matter to a broad phase; a negative value was not measured.
struct SceneDescriptor {
  float object_count = -1;
  float density_ratio = -1;     // sum of AABB volumes ÷ volume of their common bounds
  float size_spread = -1;       // standard deviation of ln(longest side)
  float speed_mean = -1;        // world units per frame
  float speed_spread = -1;      // standard deviation of the speed
  float clustering_ratio = -1;  // variance ÷ mean of object counts over equal cells; 1 is uniform
  float static_ratio = -1;      // fraction of objects that did not move
};

// Bits of ShadowSample::flags; the same values as sweepstake.v1.ShadowFlag.
enum ShadowFlag : uint32_t {
  kShadowActive = 1,  // the arm that was active on the frame thread
  kShadowCapped = 2,  // a cap of the lane ended it: the times are those of what ran until then
};

// One visit of the shadow lane: the cost of an arm off the frame thread, on copies of consecutive
// frames' boxes. Visits with the same first_frame_index were measured on the same frames and form a
// sweep; it includes the arm that was active then.
struct ShadowSample {
  uint64_t first_frame_index;
  uint64_t detection_time_ns;  // median over the measured frames: update and search
  uint64_t build_time_ns;      // of the first frame, which builds the structure, with its search
  uint64_t aabb_check_count;   // mean over the measured frames
  uint64_t native_bytes;
  uint32_t arm;
  uint32_t object_count;
  uint32_t frame_count;  // measured frames, without the build and the warm-up after it
  uint32_t flags;        // ShadowFlag bits
};
static_assert(sizeof(ShadowSample) == 56);
static_assert(std::is_trivially_copyable_v<ShadowSample>);

// Who decides which arm is active; the same values as sweepstake.v1.Mode.
enum class Mode : uint32_t { kManual = 1, kAi = 2 };

// Why the active arm changed; the same values as sweepstake.v1.SwitchReason.
enum class SwitchReason : uint32_t { kPolicy = 1, kExploration = 2, kBailOut = 3, kManual = 4 };

struct SwitchCommand {
  uint64_t command_id = 0;  // 0: local
  uint32_t arm = 0;
  SwitchReason reason = SwitchReason::kPolicy;
  // A trial: two frames in a row in which the new arm makes the longest frame of late longer than
  // this share of it, in percent, and longer by 1 ms, send the game back to the arm before; so do
  // searches that take longer than those of late by a fortieth of the trial's time in all. 0: no
  // trial; at most 255, and less than 100 counts as 100.
  uint32_t trial_limit_percent = 0;
};

// What an operator wants of the game, through the daemon.
struct OperatorOrder {
  uint64_t order_id = 0;
  Mode mode = Mode::kManual;
  std::optional<uint32_t> arm;  // to use in kManual; absent: the active one
};

// A change of the mode that the decider is told about.
struct ModeChange {
  Mode mode = Mode::kAi;
  uint32_t active_arm = 0;
  uint64_t order_id = 0;  // the order that the game obeys with it; 0: its own change
};

// The decider's conclusion about the scene, held until three decisions in a row give another; the
// same values as sweepstake.v1.Verdict.
enum class Verdict : uint32_t {
  kUnknown = 0,    // nothing decided yet
  kStable = 1,     // one arm is the best with a probability of 0.8 or more
  kTie = 2,        // several arms are nearly equal: choosing the leader loses 0.5 % or less
  kAmbiguous = 3,  // the best arm is not known, and the choice matters
  kDegraded = 4,   // even the best arm misses the frame-rate floor
};

// The verdict with the leading arm.
struct SceneVerdict {
  Verdict verdict = Verdict::kUnknown;
  uint32_t leader_arm = 0;        // most probably the best; 0 while nothing is known
  double leader_probability = 0;  // of being the best, 0–1, to seven digits
};

// The outcome of a decision's candidate; the same values as sweepstake.v1.DecisionOutcome.
enum class DecisionOutcome : uint32_t {
  kKept = 1,
  kSwitched = 2,
  kHeldCooldown = 3,  // the cooldown after the latest switch has not passed
  kHeldSettling = 4,  // all frames were settling frames, or a commanded switch is under way
  kNoFrames = 5,      // there was no frame to learn from since the previous decision
  kManual = 6,        // the mode is Mode::kManual
  kExploring = 7,     // no candidate; a command goes to the next arm of the exploration
  kRejected = 8,      // a metric of the window is not finite
  kHeldGate = 9,      // the expected gain is not worth the cost of the switch
  kHeldTie = 12,      // the candidate is not better by as much as matters
};

// The latest decision and why it came out as it did, for a game that shows or logs it
// (AdaptiveBroadPhase::last_decision). A daemon tells of its decisions the commands alone: then
// there is the latest command, and the verdict that was told latest.
struct LastDecision {
  static constexpr size_t kMaxArms = 32;

  uint64_t decision_id = 0;  // from 1; 0 with a daemon
  // When it was made, or came from the daemon: SteadyClock() with a Session, otherwise the clock of
  // now_ns. Its age is the time since then.
  uint64_t time_ns = 0;
  uint32_t active_arm = 0;
  DecisionOutcome outcome = DecisionOutcome::kKept;
  std::optional<uint32_t> candidate_arm = {};  // what the policy proposed
  std::optional<SwitchCommand> command = {};   // what was commanded, with its reason
  // The expected loss of choosing the leader, relative to the cost of the best arm; 0 with a
  // daemon.
  double expected_loss_ratio = 0;
  SceneVerdict verdict = {};
  uint64_t arm_count = 0;  // of best_probability; 0: nothing is known, or with a daemon
  std::array<double, kMaxArms> best_probability{};  // of each arm to be the best
};
static_assert(std::is_trivially_copyable_v<LastDecision>);

// The outcome of a switch.
struct SwitchOutcome {
  uint64_t command_id = 0;
  uint32_t arm = 0;
  uint32_t switch_epoch = 0;
  uint64_t rebuild_time_ns = 0;  // on the frame thread; 0: built beforehand
  // Frame time above the settled mean, summed over the settling frames.
  uint64_t settling_cost_ns = 0;
  SwitchReason reason = SwitchReason::kPolicy;
  uint32_t executed = 0;  // 0: refused (no such arm, or already active)
  // The way back from a trial: the detection time that was over its limit (of two frames the
  // shorter one's) or, over its budget, at most the mean one, and the arm that was tried. 0: any
  // other switch.
  uint64_t trial_detection_time_ns = 0;
  uint32_t trial_arm = 0;
};

}  // namespace sweepstake
