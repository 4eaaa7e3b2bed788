// The frame path, which an engine calls in each frame: steps 2–6 of the one path (README).
//
//   adaptive.BeginFrame();                     // executes a pending switch, only here
//   auto pairs = adaptive.FindPairs(boxes);    // the active backend updates and searches;
//                                              // again for each substep
//   ... narrow phase, solver, rendering ...
//   adaptive.EndFrame({.frame_time_ns = dt});  // makes the sample, guards, hands it to the sink
//
// All calls are made on one thread, the frame thread, except SwitchMailbox::Post and those marked
// "any thread". None of them waits, locks, or (between switches and while the object count is
// steady) allocates; the only system call is the clock. With an executor the frame thread also
// waits for the parts of its own search. Ownership: the sink and the clock must outlive the object.
// Memory: an arm that has been active keeps its buffers, so that switching back is cheap, until
// Trim or memory_budget_bytes; native_bytes counts the active one alone. Errors: where memory runs
// out, FindPairs ends as OutOfMemory() says (hooks.h); the next call rebuilds.
//
// If there is a spare core, a shadow lane (shadow.h) measures the other arms on its own thread and
// prepares switches: a command waits some frames until the new arm's structure exists (a warm
// switch). If that takes more than half a second of frame time, the switch is executed without it
// (a cold switch).
//
// A decider may command a trial: if two frames of the new arm take too long, compared with the
// longest of the arm before, or all of them together, compared with its mean, the next frame runs
// that arm again, without asking, and the outcome says so. A trial lasts for twice the settling
// time; its first frames, paused and loading ones are not of that time and do not end it, nor do
// frames that rebuild.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sweepstake/broad_phase.h"
#include "sweepstake/frame_sample.h"
#include "sweepstake/shadow.h"
#include "sweepstake/status.h"

#include "sweepstake/names/begin.h"

namespace sweepstake {

class ViewTap;

// Receives the frame path's results. All calls but OnShadow are made on the frame thread, where
// implementations must not wait, lock or allocate.
class FrameSink {
 public:
  virtual ~FrameSink() = default;
  // Shows the boxes of the frame's first search, before its OnFrame; they are the engine's, and
  // valid during the call.
  virtual void OnBoxes(std::span<const Aabb> /*boxes*/) noexcept {}
  virtual void OnFrame(const FrameSample& sample) noexcept = 0;
  virtual void OnDescriptor(const SceneDescriptor& descriptor) noexcept = 0;
  virtual void OnSwitch(const SwitchOutcome& outcome) noexcept = 0;
  // Called where the game has obeyed an order, and where a bail-out has ended what was ordered. Not
  // called for SetMode.
  virtual void OnModeChange(const ModeChange& /*change*/) noexcept {}
  // Called on the shadow lane's thread, one call at a time.
  virtual void OnShadow(const ShadowSample& /*sample*/) noexcept {}
};

// Passes one switch command to the frame thread; a newer command overwrites one that is not yet
// taken. Any thread posts, the frame thread takes; lock-free. Bounds: an arm over 255 counts as
// 255, as does a trial's limit, and the lowest 40 bits of the command id are kept.
class SwitchMailbox {
 public:
  void Post(const SwitchCommand& command) noexcept;
  std::optional<SwitchCommand> Take() noexcept;

 private:
  // command id (40 bits) | trial's limit (8) | arm (8) | reason (8); 0 is empty.
  std::atomic<uint64_t> slot_{0};
};

// The frame path's clock: ns from any origin, monotonic. Tests script it.
class Clock {
 public:
  virtual ~Clock() = default;
  virtual uint64_t NowNs() noexcept = 0;
};

// Returns std::chrono::steady_clock as a Clock.
Clock& SteadyClock();

struct AdaptiveOptions {
  // Unique names from BroadPhaseNames(), at most 32. Empty: all.
  std::vector<std::string> arms = {};
  // Empty: the first of `arms`, or KDTree, seldom far from the best, if those are all.
  std::string initial_arm = {};
  Mode mode = Mode::kAi;
  // A longer frame is flagged (paper §4), and whether it is a bail-out says the decider. Without
  // one, and where it would end an operator's order, it is if its arm is to blame: at least half of
  // it was detection, and it was neither paused nor loading. > 0. A daemon's welcome replaces it.
  uint64_t bail_out_ns = 5'000'000'000;
  // The settling time, over which the settling cost is measured; a trial lasts for twice that. A
  // decider's, and the daemon's welcome message, replaces it for good.
  uint64_t settling_ns = 2'000'000'000;
  // Runs the parts of large searches (executor.h); borrowed, must outlive the object. Null: the
  // frame thread does all work.
  Executor* executor = nullptr;
  ShadowOptions shadow = {};
  // Pairs ascend by a and then b whatever the arm, so that a lockstep game sees no switch. The sort
  // takes the same time for each arm and is no part of a sample's detection time, so that decisions
  // and what is learnt are those without it. Cost: pair_sorter.h.
  bool sorted_pairs = false;
  // Memory of all arms, of the pairs, of their sort and of the shadow lane; 0: no limit. The lane
  // takes half of it at most. If all take more at a switch, or after a frame in which the active
  // arm has grown, the inactive arms' and then the lane's is freed as by Trim, so that this frame
  // and a later switch to those arms allocate. What the active arm and the pairs need is not
  // limited.
  uint64_t memory_budget_bytes = 0;
};

// The engine's data about the frame that ends.
struct FrameEnd {
  uint64_t frame_time_ns = 0;  // unscaled time since the previous EndFrame
  uint32_t flags = 0;          // kFramePaused, kFrameLoading
};

class AdaptiveBroadPhase {
 public:
  // kNotFound for an unknown arm, kResourceExhausted if the system has no thread for the shadow
  // lane, kInvalidArgument for other errors. `clock` and `sink` are
  // borrowed; sink may be null. The shadow lane uses SteadyClock() whatever `clock` is.
  static Result<std::unique_ptr<AdaptiveBroadPhase>> Create(const AdaptiveOptions& options,
                                                            FrameSink* sink,
                                                            Clock& clock = SteadyClock());
  ~AdaptiveBroadPhase();

  // Executes a pending switch. One from SelectArm or the guard is executed at once, and a command
  // in the mailbox is then refused. A command from the mailbox waits for the shadow lane if there
  // is one, unless it is a bail-out; a later command replaces it.
  void BeginFrame();
  // Returns the pairs of these boxes, valid until the next call; their order depends on the arm
  // unless AdaptiveOptions::sorted_pairs is set. The count may change as in
  // BroadPhase::Update. It may be called any number of times between BeginFrame and EndFrame, for
  // substeps or several fixed updates; together they are one sample, whose detection time and
  // checks are the sums and whose counts are those of the latest search (frame_sample.h). The scene
  // descriptors and the shadow lane see the first search of each frame. The sample of a frame
  // without a search (a paused game) has no detection time.
  std::span<const OverlapPair> FindPairs(std::span<const Aabb> boxes);
  // Makes the sample and passes it to the sink.
  void EndFrame(const FrameEnd& frame);

  // Frees what the next frame does not need: the buffers of inactive arms, the pairs and those of
  // their sort, and, on its own thread and soon, what the shadow lane keeps. Call it between
  // EndFrame and BeginFrame, for example when a level ends or the system is short of memory. Ends
  // the validity of FindPairs' result. The next frame allocates again, and so do later switches and
  // the lane's next sweep. Cost: it frees memory.
  void Trim();
  // Returns the bytes that memory_budget_bytes limits.
  uint64_t memory_bytes() const;

  // Chooses an arm manually; executed at the next BeginFrame. The mode stays as it is. kNotFound
  // lists the arms.
  Status SelectArm(std::string_view arm);
  // Sets the mode. In kManual, commands from the mailbox with any other reason than kManual are
  // refused, and the guard does not switch.
  void SetMode(Mode mode);
  // Sets kManual, and nothing that depends on time happens any more, so that runs repeat bit for
  // bit (builds, replays, tournaments): the clock is not read, samples have no detection time, the
  // lane rests without its structures, and commands and orders are refused. SelectArm still
  // chooses. SetMode ends it.
  void Freeze();
  // Obeys an operator at the next BeginFrame, like SetMode and SelectArm; a later order replaces
  // one that was not obeyed yet. A kManual that was ordered holds until the next order, SetMode, or
  // a frame over the bail-out limit that the arm is to blame for: then the mode is kAi again, and
  // the bail-out is answered as in that mode. Any thread. REQUIRES: the arm is one of arms().
  // Returns false, and does nothing, while frozen.
  bool Obey(const OperatorOrder& order);

  // Says whether a decider is present to answer a bail-out. Without one the guard switches: to the
  // arm with the highest posterior mean of the latest snapshot, or to the next arm in order if
  // there is no snapshot. Any thread.
  void SetDeciderPresent(bool present);
  // Sets the posterior means for that case, in the order of arms. Any thread; the latest call wins.
  void SetPosteriorMeans(std::span<const double> means);
  // Sets the settling time: that of the decider, which a daemon tells in its welcome. Any thread.
  void SetSettling(uint64_t settling_ns);
  // Sets the bail-out limit from the decider's welcome message; 0 is ignored. Any thread.
  void SetBailOutLimit(uint64_t limit_ns);

  // Sets the decider's verdict about the scene. Any thread; the latest call wins.
  void SetVerdict(const SceneVerdict& verdict);
  // Returns that verdict; kUnknown before the first. Any thread; lock-free.
  SceneVerdict verdict() const;
  // Sets the decider's latest decision. Called by the decider, one call at a time.
  void SetLastDecision(const LastDecision& decision);
  // Returns that decision; absent before the first. Any thread; lock-free.
  std::optional<LastDecision> last_decision() const;
  // Returns the outcome that was reported to the sink latest: of a switch that has settled, was
  // refused, or has ended a trial just now; absent before the first. Any thread; lock-free.
  std::optional<SwitchOutcome> last_outcome() const;

  SwitchMailbox& mailbox();
  // For a session, which shows some of a frame's boxes to an operator who asks for them.
  ViewTap& view_tap();
  // Any thread.
  Mode mode() const;
  uint32_t active_arm() const;
  uint32_t switch_epoch() const;
  // Returns the reason of the latest executed switch; kPolicy before the first. Frame thread.
  SwitchReason last_switch_reason() const;
  // Does not change after Create.
  std::span<const std::string> arms() const;
  // Returns the version of each arm's backend, in the order of arms.
  std::span<const uint32_t> arm_versions() const;
  // Returns the sample of the last EndFrame.
  const FrameSample& last_sample() const;
  // Returns the shadow lane's state and counters. Any thread.
  ShadowStats shadow_stats() const;

 private:
  friend class AdaptiveFactory;
  class Impl;
  explicit AdaptiveBroadPhase(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace sweepstake

#include "sweepstake/names/end.h"
