// The frame path: the functions that an engine calls in each frame.
//
//   adaptive.BeginFrame();                     // executes a pending switch
//   auto pairs = adaptive.FindPairs(boxes);    // the active backend updates and searches;
//                                              // again for each substep
//   ... narrow phase, solver, rendering ...
//   adaptive.EndFrame({.frame_time_ns = dt});  // completes the sample, passes it to the sink
//
// Functions are called on one thread, the frame thread, except SwitchMailbox::Post and functions
// marked "any thread". No function waits or locks. Between switches, and while the object count is
// steady, none allocates; the only system calls are those of the clock, whose CPU times are read at
// most every 50 ms and after a long frame. With an executor the frame thread also waits for the
// parts of its own search. The sink is called in the default floating-point environment
// (broad_phase.h) or in the caller's. Ownership: the clock must outlive the object. So must the
// sink, unless a std::shared_ptr owns it; the object then keeps the sink alive, as it does the sink
// of a session (session.h). Such a sink must not own the object, because then neither would be
// destroyed. AdaptiveSession (adaptive_session.h) makes and owns all of it.
//
// Memory: an arm that was active keeps its buffers, so that switching back is cheap. Trim or
// memory_budget_bytes frees them. FrameSample::native_bytes counts the active arm alone. Errors: if
// memory runs out, FindPairs ends as described at OutOfMemory() (hooks.h); the next call rebuilds.
// So does the call after one with more pairs than max_pairs.
//
// If a core is free, a shadow lane (shadow.h) measures the other arms on its own thread and
// prepares switches. A command then waits some frames until the new arm's structure exists (a warm
// switch). After half a second of frame time the switch is executed without that structure (a cold
// switch).
//
// A decider may command a trial. A trial ends early if the new arm is too expensive
// (SwitchCommand). There are two cases:
// - A search takes longer than the previous arm's by too much. It is stopped, and the previous arm,
//   which has kept its structure, answers the frame. So FindPairs always returns all pairs.
// - All searches together exceed the previous arm's mean by too much.
// The game then runs the previous arm again, without a command, and the outcome reports that. A
// trial lasts for twice the settling time. Its first frames, and paused, loading and suspended
// frames, do not count towards that time.
//
// A forked child process may destroy the object, and do nothing else with it. The same holds for a
// Session.
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

class ProxySet;
class SessionAttachment;
class ViewTap;

// Receives the results of the frame path. All functions except OnShadow are called on the frame
// thread. There, implementations must not wait, lock or allocate.
class FrameSink : public std::enable_shared_from_this<FrameSink> {
 public:
  virtual ~FrameSink() = default;
  // Called with the boxes of the frame's first search, before the frame's OnFrame. The boxes belong
  // to the engine and are valid during the call only.
  virtual void OnBoxes(std::span<const Aabb> /*boxes*/) noexcept {}
  virtual void OnFrame(const FrameSample& sample) noexcept = 0;
  virtual void OnDescriptor(const SceneDescriptor& descriptor) noexcept = 0;
  virtual void OnSwitch(const SwitchOutcome& outcome) noexcept = 0;
  // Called in three cases: SetMode or Freeze was called, the game has executed an operator's order,
  // or a bail-out has ended a kManual that an operator ordered.
  virtual void OnModeChange(const ModeChange& /*change*/) noexcept {}
  // Called on the shadow lane's thread, one call at a time.
  virtual void OnShadow(const ShadowSample& /*sample*/) noexcept {}
};

// Passes one switch command to the frame thread. A newer command overwrites one that was not taken
// yet. Any thread may call Post; only the frame thread calls Take. Lock-free. Arms and trial limits
// over 255 are stored as 255. Only the lowest 40 bits of the command id are kept.
class SwitchMailbox {
 public:
  void Post(const SwitchCommand& command) noexcept;
  std::optional<SwitchCommand> Take() noexcept;

 private:
  // Layout: command id (40 bits) | trial limit (8) | arm (8) | reason (8). The value 0 means empty.
  std::atomic<uint64_t> slot_{0};
};

// The clock of the frame path, in ns. It never goes back; its zero point does not matter. Tests
// replace it.
class Clock {
 public:
  virtual ~Clock() = default;
  virtual uint64_t NowNs() noexcept = 0;
  // Return the CPU time of the calling thread, and of all threads of the process. 0 means that it
  // is unknown; no frame is then flagged with kFrameSuspended.
  virtual uint64_t ThreadCpuNs() noexcept { return 0; }
  virtual uint64_t ProcessCpuNs() noexcept { return 0; }
};

// Returns std::chrono::steady_clock and the system's CPU times as a Clock.
Clock& SteadyClock();

struct AdaptiveOptions {
  // Unique names from BroadPhaseNames(), at most 32. Empty: all.
  std::vector<std::string> arms = {};
  // The arm at the start. Empty: the first of `arms`; if `arms` is empty, KDTree, because it is
  // seldom much slower than the best arm.
  std::string initial_arm = {};
  Mode mode = Mode::kAi;
  // A longer frame is flagged with kFrameBailOut (paper §4). The decider judges whether a flagged
  // frame is a bail-out. Without a decider, and when deciding whether to end an operator's order, a
  // flagged frame is a bail-out if its arm is to blame: detection took at least half of the frame,
  // and the game was neither paused nor loading. A frame with kFrameSuspended is not flagged. Must
  // be > 0. A daemon's welcome message replaces the value.
  uint64_t bail_out_ns = kBailOutNs;
  // Time after a switch during which its settling cost is measured. A trial lasts for twice this
  // time. The embedded decider, or a daemon's welcome message, replaces the value permanently.
  uint64_t settling_ns = 2'000'000'000;
  // Runs the parts of large searches (executor.h); borrowed, must outlive the object. Null: the
  // frame thread does all work.
  Executor* executor = nullptr;
  ShadowOptions shadow = {};
  // Returns pairs in ascending order of a and then b, whatever the arm, so that a switch does not
  // change a lockstep game. Sorting takes the same time for each arm and is not part of a sample's
  // detection time. Cost: pair_sorter.h.
  bool sorted_pairs = false;
  // Limits the total memory of all arms, of pairs and their sorting, and of the shadow lane; 0: no
  // limit. The lane may use at most half of it. The limit is checked at each switch, and after a
  // frame in which the active arm has grown. If it is exceeded, the memory of the inactive arms is
  // freed, and then the memory of the lane if necessary, as by Trim. That frame and later switches
  // to those arms then allocate. The memory of the active arm and of the pairs is never freed.
  uint64_t memory_budget_bytes = 0;
  // The maximum number of pairs of a search, of each arm (BroadPhaseOptions::max_pairs); 0: no
  // limit. FindPairs returns no pairs for a search with more (pairs_exceeded).
  uint64_t max_pairs = 0;
};

// What the engine reports about the frame that ends.
struct FrameEnd {
  uint64_t frame_time_ns = 0;  // unscaled time since the previous EndFrame
  uint32_t flags = 0;          // kFramePaused, kFrameLoading, both or neither
};

class AdaptiveBroadPhase {
 public:
  // Makes the object. `clock` and `sink` are borrowed (see Ownership above); sink may be null. The
  // shadow lane always uses SteadyClock(). Errors: kNotFound for an unknown arm, kResourceExhausted
  // if the system cannot create the lane's thread, kInvalidArgument otherwise.
  static Result<std::unique_ptr<AdaptiveBroadPhase>> Create(const AdaptiveOptions& options,
                                                            FrameSink* sink,
                                                            Clock& clock = SteadyClock());
  // Stops the session that was started with this object, if any, as by Session::Stop(0).
  ~AdaptiveBroadPhase();

  // Executes at most one pending switch. One by SelectArm or a guard is executed at once; a waiting
  // command is then refused. A command waits for the shadow lane, if there is one, to prepare its
  // arm, at most 500 ms; a bail-out does not wait. A newer command replaces one that still waits.
  void BeginFrame();
  // Returns the pairs of these boxes, valid until the next call. Their order depends on the arm
  // unless AdaptiveOptions::sorted_pairs is set. The number of boxes may change as in
  // BroadPhase::Update.
  //
  // It may be called any number of times between BeginFrame and EndFrame, for substeps or several
  // fixed updates. Together these searches are one sample: times and checks are summed, counts come
  // from the latest search (frame_sample.h). Scene descriptors and the shadow lane use only the
  // first search of each frame. A frame without a search (a paused game) has detection time 0.
  std::span<const OverlapPair> FindPairs(std::span<const Aabb> boxes);
  // Searches the set's moving_boxes() and returns the pairs of ProxySet::Resolve, both with
  // max_pairs. If either has more pairs, returns none, the set has no events, and pairs_exceeded()
  // is true. The time of Resolve is not measured.
  std::span<const OverlapPair> FindPairs(ProxySet& proxies);
  // Returns whether the latest FindPairs found more pairs than AdaptiveOptions::max_pairs. It then
  // ended early and returned none. The frame gets kFramePairsExceeded and is not evidence about its
  // arm. The next search rebuilds, unless only the pairs of a ProxySet were too many.
  bool pairs_exceeded() const;
  // Returns AdaptiveOptions::max_pairs.
  uint64_t max_pairs() const;
  // Completes the sample and passes it to the sink.
  void EndFrame(const FrameEnd& frame);

  // Frees buffers that the next frame does not need: the buffers of inactive arms, of pairs, and of
  // sorting. The shadow lane frees its memory soon after, on its own thread. Call it between
  // EndFrame and BeginFrame, for example when a level ends or memory is low. It invalidates the
  // result of FindPairs. The next frame, later switches and the lane's next sweep allocate again.
  // Cost: the time to free the memory.
  void Trim();
  // Returns the number of bytes in use that memory_budget_bytes limits.
  uint64_t memory_bytes() const;

  // Chooses an arm manually, from the next BeginFrame on. The mode does not change. Error:
  // kNotFound, with a message that lists the arms.
  Status SelectArm(std::string_view arm);
  // Sets the mode and reports it to the sink. In kManual the bail-out guard does not switch, and
  // commands from the mailbox are refused unless their reason is kManual.
  void SetMode(Mode mode);
  // Sets kManual and disables everything that depends on time, so that runs repeat bit for bit
  // (builds, replays, tournaments). The clock is not read, samples have no detection time, the lane
  // rests without its structures, and commands and orders are refused. SelectArm still works.
  // SetMode ends this state.
  void Freeze();
  // Queues an operator's order, which the next BeginFrame executes like SetMode and SelectArm. A
  // later order replaces one that was not executed yet. A kManual that was ordered ends with
  // - the next order,
  // - SetMode, or
  // - a frame over the bail-out limit for which the arm is to blame. The mode then becomes kAi
  //   again, and the frame is treated as in that mode. Any thread. Returns false, and does nothing,
  //   while frozen. REQUIRES: the arm is one of arms().
  bool Obey(const OperatorOrder& order);

  // Sets whether a decider is present. A decider reacts to bail-outs itself. Without one the
  // bail-out guard switches to the arm with the highest posterior mean (SetPosteriorMeans) or, if
  // there are none, to the next arm in order. Any thread.
  void SetDeciderPresent(bool present);
  // Sets the posterior mean of each arm, in the order of arms. Any thread; each call replaces the
  // values of the previous call.
  void SetPosteriorMeans(std::span<const double> means);
  // Sets the settling time, for example from a daemon's welcome message. Any thread.
  void SetSettling(uint64_t settling_ns);
  // Sets whether the decider learns from the shadow lane. If not, a lane with ShadowMode::kAuto
  // rests and prepares no switches; kOn always runs. Any thread.
  void SetLaneUse(bool used);
  // Sets the bail-out limit, for example from a daemon's welcome message. 0 is ignored. Any
  // thread.
  void SetBailOutLimit(uint64_t limit_ns);

  // Sets the decider's verdict about the scene. Any thread; each call replaces the previous
  // verdict.
  void SetVerdict(const SceneVerdict& verdict);
  // Returns the latest verdict; kUnknown before the first. Any thread; lock-free.
  SceneVerdict verdict() const;
  // Sets the decider's latest decision. Called by the decider, by one thread at a time.
  void SetLastDecision(const LastDecision& decision);
  // Returns the latest decision; absent before the first. Any thread; lock-free.
  std::optional<LastDecision> last_decision() const;
  // Returns the latest outcome passed to the sink: of a switch that has settled or was refused, or
  // of the end of a trial. Absent before the first. Any thread; lock-free.
  std::optional<SwitchOutcome> last_outcome() const;

  // Attaches a session, which the destructor then stops. Called by Session::Start. Returns false,
  // and does nothing, while another session is attached.
  bool Attach(std::shared_ptr<SessionAttachment> attachment);
  SwitchMailbox& mailbox();
  // Through this object a session copies boxes of some frames, which operators can view.
  ViewTap& view_tap();
  // Any thread.
  Mode mode() const;
  // Returns the arm that was active after Create.
  uint32_t initial_arm() const;
  uint32_t active_arm() const;
  uint32_t switch_epoch() const;
  // Returns the reason of the latest executed switch; kPolicy before the first. Frame thread only.
  SwitchReason last_switch_reason() const;
  // Returns the names of the arms, which never change after Create.
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
