// The frame path, which an engine calls in each frame.
//
//   adaptive.BeginFrame();                     // executes a pending switch, only here
//   auto pairs = adaptive.FindPairs(boxes);    // the active backend updates and searches;
//                                              // again for each substep
//   ... narrow phase, solver, rendering ...
//   adaptive.EndFrame({.frame_time_ns = dt});  // completes the sample, passes it to the sink
//
// All calls are made on one thread, the frame thread, except SwitchMailbox::Post and those marked
// "any thread". No call waits or locks. Between switches, and while the object count is steady, no
// call allocates; the only system call is the clock. With an executor the frame thread also waits
// for the parts of its own search. Ownership: the sink and the clock must outlive the object.
//
// Memory: an arm that was active keeps its buffers until Trim or memory_budget_bytes, so that
// switching back is cheap. FrameSample::native_bytes counts the active arm alone. Errors: if memory
// runs out, FindPairs ends as described at OutOfMemory() (hooks.h); the next call rebuilds.
//
// If there is a spare core, a shadow lane (shadow.h) measures the other arms on its own thread and
// prepares switches. A command then waits some frames until the new arm's structure exists (a warm
// switch). After half a second of frame time the switch is executed without it (a cold switch).
//
// A decider may command a trial. A trial ends early if the new arm is too expensive. That is so if
// two frames in a row exceed the longest recent frame of the previous arm by too much, or all
// frames together exceed its mean. The next frame then runs the previous arm again, without a
// command, and the outcome reports it. A trial lasts for twice the settling time. Its first frames,
// paused and loading frames do not count towards that time and do not end it; frames that rebuild
// do not end it either.
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

// Receives the results of the frame path. All calls except OnShadow are made on the frame thread;
// implementations must not wait, lock or allocate there.
class FrameSink {
 public:
  virtual ~FrameSink() = default;
  // Called with the boxes of the frame's first search, before the frame's OnFrame. The boxes belong
  // to the engine and are valid during the call only.
  virtual void OnBoxes(std::span<const Aabb> /*boxes*/) noexcept {}
  virtual void OnFrame(const FrameSample& sample) noexcept = 0;
  virtual void OnDescriptor(const SceneDescriptor& descriptor) noexcept = 0;
  virtual void OnSwitch(const SwitchOutcome& outcome) noexcept = 0;
  // Called when the game has executed an operator's order, and when a bail-out has ended a kManual
  // that an operator ordered. Not called for SetMode.
  virtual void OnModeChange(const ModeChange& /*change*/) noexcept {}
  // Called on the shadow lane's thread, one call at a time.
  virtual void OnShadow(const ShadowSample& /*sample*/) noexcept {}
};

// Passes one switch command to the frame thread. A newer command overwrites one that was not yet
// taken. Any thread may call Post, only the frame thread Take. Lock-free. Arms and trial limits
// over 255 are stored as 255; of the command id the lowest 40 bits are kept.
class SwitchMailbox {
 public:
  void Post(const SwitchCommand& command) noexcept;
  std::optional<SwitchCommand> Take() noexcept;

 private:
  // Layout: command id (40 bits) | trial's limit (8) | arm (8) | reason (8). The value 0 means
  // empty.
  std::atomic<uint64_t> slot_{0};
};

// The frame path's clock: ns from any origin, monotonic. Tests replace it.
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
  // Empty: the first of `arms`, or KDTree if `arms` is empty; KDTree is seldom far from the best.
  std::string initial_arm = {};
  Mode mode = Mode::kAi;
  // Frames longer than this are flagged (paper §4); the decider judges whether a flagged frame is a
  // bail-out. Without a decider, and to end an operator's order, a flagged frame is a bail-out if
  // its arm is to blame. That is so if detection took at least half of the frame, and the game was
  // neither paused nor loading. > 0. A daemon's welcome message replaces the value.
  uint64_t bail_out_ns = 5'000'000'000;
  // The time after a switch over which its settling cost is measured. A trial lasts for twice that.
  // The embedded decider and a daemon's welcome message replace the value permanently.
  uint64_t settling_ns = 2'000'000'000;
  // Runs the parts of large searches (executor.h); borrowed, must outlive the object. Null: the
  // frame thread does all work.
  Executor* executor = nullptr;
  ShadowOptions shadow = {};
  // Returns pairs in ascending order of a and then b, whatever the arm, so that a switch does not
  // change a lockstep game. Sorting takes the same time for each arm and is not part of a sample's
  // detection time. Cost: pair_sorter.h.
  bool sorted_pairs = false;
  // Limits the memory of all arms, for pairs and for sorting them, and of the shadow lane; 0: no
  // limit. The lane may use half of it. The limit is checked at each switch and after a frame in
  // which the active arm has grown. Above it the memory of the inactive arms is freed, and then
  // that of the lane, as by Trim: this frame and later switches to those arms then allocate. The
  // active arm and the pairs are not limited.
  uint64_t memory_budget_bytes = 0;
};

// The engine's data about the frame that ends.
struct FrameEnd {
  uint64_t frame_time_ns = 0;  // unscaled time since the previous EndFrame
  uint32_t flags = 0;          // kFramePaused, kFrameLoading, both or neither
};

class AdaptiveBroadPhase {
 public:
  // Returns kNotFound for an unknown arm, kResourceExhausted if the system has no thread for the
  // shadow lane, and kInvalidArgument for other errors. `clock` and `sink` are borrowed; sink may
  // be null. The shadow lane always uses SteadyClock().
  static Result<std::unique_ptr<AdaptiveBroadPhase>> Create(const AdaptiveOptions& options,
                                                            FrameSink* sink,
                                                            Clock& clock = SteadyClock());
  ~AdaptiveBroadPhase();

  // Executes a pending switch. A switch from SelectArm or the guard is executed at once, and a
  // command in the mailbox is then refused. A command from the mailbox waits for the shadow lane if
  // one exists, unless it is a bail-out. A later command replaces it.
  void BeginFrame();
  // Returns the pairs of these boxes, valid until the next call. Their order depends on the arm
  // unless AdaptiveOptions::sorted_pairs is set. The count may change as in BroadPhase::Update. It
  // may be called any number of times between BeginFrame and EndFrame, for substeps or several
  // fixed updates. Together these searches are one sample: times and checks are summed, counts are
  // those of the latest search (frame_sample.h). Scene descriptors and shadow lane use the first
  // search of each frame. The sample of a frame without a search (a paused game) has detection time
  // 0.
  std::span<const OverlapPair> FindPairs(std::span<const Aabb> boxes);
  // Completes the sample and passes it to the sink.
  void EndFrame(const FrameEnd& frame);

  // Frees the buffers that the next frame does not need: those of inactive arms, and those for
  // pairs and for sorting them. The shadow lane frees its memory soon after, on its own thread.
  // Call it between EndFrame and BeginFrame, for example when a level ends or memory is low. It
  // invalidates the result of FindPairs. The next frame, later switches and the lane's next sweep
  // allocate again. Cost: that of freeing the memory.
  void Trim();
  // Returns the bytes that memory_budget_bytes limits.
  uint64_t memory_bytes() const;

  // Chooses an arm manually; executed at the next BeginFrame. The mode does not change. The message
  // of kNotFound lists the arms.
  Status SelectArm(std::string_view arm);
  // Sets the mode. In kManual the guard does not switch, and commands from the mailbox are refused
  // unless their reason is kManual.
  void SetMode(Mode mode);
  // Sets kManual and disables everything that depends on time, so that runs repeat bit for bit
  // (builds, replays, tournaments). The clock is not read, samples have no detection time, the lane
  // rests without its structures, and commands and orders are refused. SelectArm still works.
  // SetMode ends this state.
  void Freeze();
  // Queues an operator's order, which is executed at the next BeginFrame like SetMode and
  // SelectArm. A later order replaces one that was not executed yet. An ordered kManual holds until
  // the next order, until SetMode, or until a frame over the bail-out limit for which the arm is to
  // blame. In that last case the mode becomes kAi again, and the bail-out is treated as in that
  // mode. Any thread. REQUIRES: the arm is one of arms(). Returns false, and does nothing, while
  // frozen.
  bool Obey(const OperatorOrder& order);

  // Sets whether a decider is present, which then reacts to bail-outs. Without one the guard
  // switches: to the arm with the highest posterior mean of the latest snapshot, or without a
  // snapshot to the next arm in order. Any thread.
  void SetDeciderPresent(bool present);
  // Sets these posterior means, in the order of arms. Any thread; the latest call wins.
  void SetPosteriorMeans(std::span<const double> means);
  // Sets the settling time, for example that of a daemon's welcome message. Any thread.
  void SetSettling(uint64_t settling_ns);
  // Sets the bail-out limit, for example that of a daemon's welcome message; 0 is ignored. Any
  // thread.
  void SetBailOutLimit(uint64_t limit_ns);

  // Sets the decider's verdict about the scene. Any thread; the latest call wins.
  void SetVerdict(const SceneVerdict& verdict);
  // Returns the latest verdict; kUnknown before the first. Any thread; lock-free.
  SceneVerdict verdict() const;
  // Sets the decider's latest decision. Called by the decider, one call at a time.
  void SetLastDecision(const LastDecision& decision);
  // Returns the latest decision; absent before the first. Any thread; lock-free.
  std::optional<LastDecision> last_decision() const;
  // Returns the latest outcome passed to the sink: of a switch that has settled or was refused, or
  // of the end of a trial. Absent before the first. Any thread; lock-free.
  std::optional<SwitchOutcome> last_outcome() const;

  SwitchMailbox& mailbox();
  // Lets a session copy boxes of some frames for operators who want to see them.
  ViewTap& view_tap();
  // Any thread.
  Mode mode() const;
  uint32_t active_arm() const;
  uint32_t switch_epoch() const;
  // Returns the reason of the latest executed switch; kPolicy before the first. Frame thread only.
  SwitchReason last_switch_reason() const;
  // Never changes after Create.
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
