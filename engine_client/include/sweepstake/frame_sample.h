// The cost of one frame (paper §4: FPS, DET, MEM, CHK) and its context. Plain data.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <type_traits>

namespace sweepstake {

// Bits of FrameSample::flags; the same values as sweepstake.v1.FrameFlag.
enum FrameFlag : uint32_t {
  kFrameRebuild = 1,     // the backend's structure was rebuilt
  kFramePaused = 2,      // the game was paused or in the background
  kFrameLoading = 4,     // a scene was loading
  kFrameBailOut = 8,     // the frame was over the bail-out limit
  kFrameSuspended = 16,  // the system stopped the process during the frame (SIGSTOP, breakpoint)
  kFramePairsExceeded = 32,  // a search ended early: more pairs than AdaptiveOptions::max_pairs
};
// Flags of frames whose times are not the cost of their arm. Nothing learns from these frames.
inline constexpr uint32_t kFrameWithoutCost =
    kFramePaused | kFrameLoading | kFrameSuspended | kFramePairsExceeded;

inline constexpr uint64_t kBailOutNs = 5'000'000'000;  // the default bail-out limit

// Weights of the four scores in the paper's reward (paper §4). Each is finite and >= 0; their sum
// is 1 ± 1e-9. Only policy `paper` uses them: the reward of AI Decides depends on the detection
// time alone.
struct RewardWeights {
  double fps = 0.55;
  double detection = 0.25;
  double memory = 0.12;
  double checks = 0.08;

  friend bool operator==(const RewardWeights&, const RewardWeights&) = default;
};

// The rules of a decider that a game can set for its own session. EmbeddedOptions documents the
// fields. Absent: the decider's own value.
struct DecisionRules {
  std::optional<RewardWeights> weights = {};
  std::optional<uint64_t> decision_interval_ns = {};
  std::optional<uint64_t> cooldown_ns = {};
  std::optional<uint64_t> settling_ns = {};

  friend bool operator==(const DecisionRules&, const DecisionRules&) = default;
};

// The cost of one frame. A frame may search several times, once per substep. Times and checks are
// then summed; bytes, pairs and objects come from the latest search.
struct FrameSample {
  uint64_t frame_index = 0;        // counts from the start of the session
  uint64_t frame_time_ns = 0;      // unscaled time of the whole frame
  uint64_t detection_time_ns = 0;  // Build or Update plus FindPairs; 0 without a search
  uint64_t aabb_check_count = 0;
  uint64_t native_bytes = 0;
  uint32_t pair_count = 0;
  uint32_t object_count = 0;
  uint32_t arm = 0;           // index in the session's list of arms
  uint32_t switch_epoch = 0;  // executed switches before this frame
  uint32_t flags = 0;         // FrameFlag bits
  // Objects whose boxes are invalid but not empty (aabb.h), so that they overlap nothing. Boxes
  // that were added count at once. A box that changes later counts within object_count ÷ 4 frames.
  uint32_t invalid_box_count = 0;
};
static_assert(sizeof(FrameSample) == 64);
static_assert(std::is_trivially_copyable_v<FrameSample>);

// Returns whether the frame took long because of its arm: detection took at least half of the
// frame, and the times are the cost of the arm (kFrameWithoutCost).
inline bool IsCausedByDetection(const FrameSample& sample) {
  return (sample.flags & kFrameWithoutCost) == 0 &&
         sample.detection_time_ns >= sample.frame_time_ns - sample.frame_time_ns / 2;
}

// The properties of a scene that matter to a broad phase. A negative value means "not measured".
struct SceneDescriptor {
  float object_count = -1;
  float density_ratio = -1;     // sum of AABB volumes ÷ volume of their common bounds
  float size_spread = -1;       // standard deviation of ln(longest side)
  float speed_mean = -1;        // mean distance per frame, in world units
  float speed_spread = -1;      // standard deviation of that distance
  float clustering_ratio = -1;  // variance ÷ mean of object counts over equal cells; 1 is uniform
  float static_ratio = -1;      // fraction of objects that did not move
};

// Bits of ShadowSample::flags; the same values as sweepstake.v1.ShadowFlag.
enum ShadowFlag : uint32_t {
  kShadowActive = 1,  // the arm that was active on the frame thread
  kShadowCapped = 2,  // a cap of the lane ended the visit; times cover the part before
};

// One visit of the shadow lane: the cost of an arm, measured on the lane's thread with copies of
// consecutive frames' boxes. Visits with the same first_frame_index form a sweep: they were
// measured on the same frames. One of them is of the arm that was active then.
struct ShadowSample {
  uint64_t first_frame_index = 0;
  uint64_t detection_time_ns = 0;  // time to update and search, median of the measured frames
  uint64_t build_time_ns = 0;      // time of the first frame, which builds and searches
  uint64_t aabb_check_count = 0;   // mean over the measured frames
  uint64_t native_bytes = 0;
  uint32_t arm = 0;
  uint32_t object_count = 0;
  uint32_t frame_count = 0;  // measured frames, without the build and the warm-up after it
  uint32_t flags = 0;        // ShadowFlag bits
};
static_assert(sizeof(ShadowSample) == 56);
static_assert(std::is_trivially_copyable_v<ShadowSample>);

// Whether the game or an operator chooses the active arm (kManual) or the policy does (kAi). The
// same values as sweepstake.v1.Mode.
enum class Mode : uint32_t { kManual = 1, kAi = 2 };

// Why the active arm changed; the same values as sweepstake.v1.SwitchReason.
enum class SwitchReason : uint32_t { kPolicy = 1, kExploration = 2, kBailOut = 3, kManual = 4 };

struct SwitchCommand {
  uint64_t command_id = 0;  // 0: not from a decider
  uint32_t arm = 0;
  SwitchReason reason = SwitchReason::kPolicy;
  // Nonzero: the switch is a trial, which returns to the previous arm in two cases (trial_guard.h).
  // First: a search takes trial_limit_percent % of the longest recent search but one of the
  // previous arm, and a twentieth of a frame more than that search. What the trial has saved so far
  // is added to the limit, at most the margin once more. The search is then stopped, and the
  // previous arm answers the frame. Second: all searches together take longer than the same number
  // of average searches of the previous arm, by a fortieth of the trial's duration. If the frame
  // thread builds the new structure, the first three searches may take five times the longest
  // recent one but one. At most 255; below 100 counts as 100. 0: no trial.
  uint32_t trial_limit_percent = 0;
};

// An order of an operator for the game, sent through the daemon.
struct OperatorOrder {
  uint64_t order_id = 0;
  Mode mode = Mode::kManual;
  std::optional<uint32_t> arm;  // the arm to use in kManual; absent: the active one
};

// A change of the mode that is reported to the decider.
struct ModeChange {
  Mode mode = Mode::kAi;
  uint32_t active_arm = 0;
  uint64_t order_id = 0;  // the order that the game executes with it; 0: the game's own change
};

// The decider's conclusion about the scene. It changes only after three decisions in a row give the
// same new verdict. The same values as sweepstake.v1.Verdict.
enum class Verdict : uint32_t {
  kUnknown = 0,    // nothing decided yet
  kStable = 1,     // one arm is the best with a probability of at least 0.8
  kTie = 2,        // several arms are nearly equal: choosing the leader loses 0.5 % or less
  kAmbiguous = 3,  // the best arm is uncertain, and the choice matters
  kDegraded = 4,   // even with the best arm, detection makes the game miss the frame-rate floor
};

// The verdict, and the arm that leads with its probability.
struct SceneVerdict {
  Verdict verdict = Verdict::kUnknown;
  uint32_t leader_arm = 0;        // most probably the best arm; 0 while nothing is known
  double leader_probability = 0;  // the probability that it is the best, 0–1, to seven digits
};

// An arm's cost ÷ the cost of the leader (the arm that is most probably the best). The true ratio
// is below the median with a probability of 50 %, and between low and high with 95 %.
struct CostRatio {
  double median = 1;
  double low = 1;
  double high = 1;
  bool operator==(const CostRatio&) const = default;
};

// A session's measurements of an arm, and the conclusions from them in readable units.
struct ArmStanding {
  uint64_t live_window_count = 0;  // windows with this arm active that the policy learnt from
  uint64_t lane_visit_count = 0;   // visits of the shadow lane that the policy learnt from
  // The width of the posterior, expressed as the number of live windows of an unchanging arm that
  // would give the same width. Priors and evidence of the lane are included.
  double effective_window_count = 0;
  double best_probability = 0;  // the probability that this arm is the best
  // The arm's cost ÷ the leader's. Absent if one of the two costs is unknown, or if the policy's
  // reward does not depend on the cost alone.
  std::optional<CostRatio> cost_ratio;
};

// The outcome of a decision's candidate; the same values as sweepstake.v1.DecisionOutcome.
enum class DecisionOutcome : uint32_t {
  kKept = 1,
  kSwitched = 2,
  kHeldCooldown = 3,  // the cooldown after the latest switch has not passed
  kHeldSettling = 4,  // all frames were settling frames, or a switch is in progress
  kNoFrames = 5,      // there was no frame to learn from since the previous decision
  kManual = 6,        // the mode is Mode::kManual
  kExploring = 7,     // no candidate; a command goes to the next arm of the exploration
  kRejected = 8,      // a metric of the window is not finite
  kHeldGate = 9,      // the expected gain is less than the cost of the switch
};

// The latest decision and its reasons, for a game that shows or logs them
// (AdaptiveBroadPhase::last_decision). A daemon does not send its decisions: the fields then
// describe its latest command, and `verdict` is the latest one received.
struct LastDecision {
  static constexpr size_t kMaxArms = 32;

  uint64_t decision_id = 0;  // counts from 1; 0 with a daemon, which does not send it
  // Time of the decision, or of receiving it from the daemon. The clock is SteadyClock() with a
  // Session, otherwise the clock of `now_ns`.
  uint64_t time_ns = 0;
  uint32_t active_arm = 0;
  DecisionOutcome outcome = DecisionOutcome::kKept;
  std::optional<uint32_t> candidate_arm = {};  // the arm that the policy proposed; absent: none
  std::optional<SwitchCommand> command = {};   // the command and its reason; absent: none
  // The expected loss of choosing the leader, relative to the cost of the best arm; 0 with a
  // daemon.
  double expected_loss_ratio = 0;
  SceneVerdict verdict = {};
  uint64_t arm_count = 0;  // number of entries of best_probability; 0: unknown, or with a daemon
  std::array<double, kMaxArms> best_probability{};  // the probability of each arm to be the best
};
static_assert(std::is_trivially_copyable_v<LastDecision>);

// The outcome of a switch.
struct SwitchOutcome {
  uint64_t command_id = 0;
  uint32_t arm = 0;
  uint32_t switch_epoch = 0;
  uint64_t rebuild_time_ns = 0;  // time to build on the frame thread; 0: built before the switch
  // Frame time above the settled mean, summed over the settling frames.
  uint64_t settling_cost_ns = 0;
  SwitchReason reason = SwitchReason::kPolicy;
  uint32_t executed = 0;  // 0: refused (no such arm, or already active)
  // Set only if the switch ends a trial that was too expensive; otherwise 0. It is the mean time of
  // the trial's searches, without the first three unless one of them was stopped. A stopped search
  // counts with its limit. trial_arm is the tried arm.
  uint64_t trial_detection_time_ns = 0;
  uint32_t trial_arm = 0;
};

}  // namespace sweepstake
