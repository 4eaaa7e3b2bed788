// The frame path: what an engine calls each frame. Steps 2–6 of the one path (README).
//
//   adaptive.BeginFrame();                     // executes a pending switch, only here
//   auto pairs = adaptive.FindPairs(boxes);    // the active backend updates and searches
//   ... narrow phase, solver, rendering ...
//   adaptive.EndFrame({.frame_time_ns = dt});  // makes the sample, guards, hands it to the sink
//
// All calls on one thread, the frame thread, but SwitchMailbox::Post and what says "any thread".
// None of them waits, locks, or (between switches and while the object count is steady) allocates;
// the only system call is the clock. (With an executor the frame thread also waits for the parts of
// its own search.) Ownership: the sink and the clock must outlive the object.
// Memory: an arm that has been active keeps its buffers, so that switching back is cheap;
// native_bytes counts the active one alone. Errors: std::bad_alloc from FindPairs when a backend
// runs out of memory; the next one builds anew.
//
// Where there is a core to spare, a shadow lane (shadow.h) measures the other arms on a thread of
// its own, and prepares a switch: the command waits some frames, until the new arm's structure is
// there (a warm switch), and is executed without one (a cold switch) where that takes over half a
// second of frame time.
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

namespace sweepstake {

// Takes what the frame path produces. Called on the frame thread, but for OnShadow:
// implementations must not wait, lock or allocate.
class FrameSink {
 public:
  virtual ~FrameSink() = default;
  virtual void OnFrame(const FrameSample& sample) noexcept = 0;
  virtual void OnDescriptor(const SceneDescriptor& descriptor) noexcept = 0;
  virtual void OnSwitch(const SwitchOutcome& outcome) noexcept = 0;
  // Called on the shadow lane's thread, one call at a time.
  virtual void OnShadow(const ShadowSample& /*sample*/) noexcept {}
};

// One switch command on its way to the frame thread; the latest wins, an older one not yet taken is
// overwritten. Any thread posts, the frame thread takes; lock-free. Bounds: an arm over 255 counts
// as 255, of the command id the lowest 48 bits are kept.
class SwitchMailbox {
 public:
  void Post(const SwitchCommand& command) noexcept;
  std::optional<SwitchCommand> Take() noexcept;

 private:
  // command id (48 bits) | arm (8) | reason (8); 0 is empty.
  std::atomic<uint64_t> slot_{0};
};

// Time for the frame path, ns from any origin, never going back. Tests script it.
class Clock {
 public:
  virtual ~Clock() = default;
  virtual uint64_t NowNs() noexcept = 0;
};

// std::chrono::steady_clock.
Clock& SteadyClock();

struct AdaptiveOptions {
  std::vector<std::string> arms =
      {};                        // names from BroadPhaseNames(); empty: all seven. 1–32, unique.
  std::string initial_arm = {};  // empty: the first
  Mode mode = Mode::kAi;
  // A longer frame is a bail-out (paper §4); > 0. The daemon's welcome replaces it. With an
  // embedded decider it stays, and the decider takes every frame that is flagged as over it for a
  // bail-out.
  uint64_t bail_out_ns = 5'000'000'000;
  // For the measured settling cost only; the daemon's welcome replaces it.
  uint64_t settling_ns = 2'000'000'000;
  // Runs the parts of large searches (executor.h); borrowed, must outlive the object. Null: all
  // work is done by the frame thread.
  Executor* executor = nullptr;
  ShadowOptions shadow = {};
};

// What the engine knows about the frame it ends.
struct FrameEnd {
  uint64_t frame_time_ns = 0;  // unscaled time since the previous EndFrame
  uint32_t flags = 0;          // kFramePaused, kFrameLoading
};

class AdaptiveBroadPhase {
 public:
  // kNotFound for an unknown arm, kInvalidArgument for the rest. `clock` and `sink` are borrowed;
  // sink may be null. The shadow lane goes by SteadyClock() whatever `clock` is.
  static Result<std::unique_ptr<AdaptiveBroadPhase>> Create(const AdaptiveOptions& options,
                                                            FrameSink* sink,
                                                            Clock& clock = SteadyClock());
  ~AdaptiveBroadPhase();

  // Executes a pending switch: SelectArm's or the guard's at once, before the mailbox's, which is
  // then refused. The mailbox's waits for the shadow lane where there is one, but for a bail-out's;
  // a later command takes its place.
  void BeginFrame();
  // Pairs of these boxes, valid until the next call. The count may change as in BroadPhase::Update.
  // Once per frame; a frame without it (a paused game) has a sample without detection time.
  std::span<const OverlapPair> FindPairs(std::span<const Aabb> boxes);
  // Makes the sample and hands it to the sink.
  void EndFrame(const FrameEnd& frame);

  // Manual choice, executed at the next BeginFrame; leaves the mode as it is. kNotFound lists the
  // arms.
  Status SelectArm(std::string_view arm);
  // In kManual commands from the mailbox with any reason but kManual are refused, and the guard
  // does not switch.
  void SetMode(Mode mode);

  // Says whether a decider is there to answer a bail-out. While it is not, the guard switches by
  // itself: to the arm with the highest posterior mean of the latest snapshot, else to the next arm
  // in order. Any thread.
  void SetDeciderPresent(bool present);
  // Posterior means in the order of arms, for that case. Any thread; latest wins.
  void SetPosteriorMeans(std::span<const double> means);
  // The settling time in force, from the decider's welcome. Any thread.
  void SetSettling(uint64_t settling_ns);
  // The bail-out limit in force, from the decider's welcome; 0 is ignored. Any thread.
  void SetBailOutLimit(uint64_t limit_ns);

  // What the decider says about the scene, from its latest snapshot. Any thread; latest wins.
  void SetVerdict(const SceneVerdict& verdict);
  // That verdict, for the game to react to: kUnknown before the first. Any thread; lock-free.
  SceneVerdict verdict() const;

  SwitchMailbox& mailbox();
  // Any thread.
  Mode mode() const;
  uint32_t active_arm() const;
  uint32_t switch_epoch() const;
  // Why the latest executed switch was made; kPolicy before the first. Frame thread.
  SwitchReason last_switch_reason() const;
  // Fixed since Create.
  std::span<const std::string> arms() const;
  // Version of each arm's backend, in the order of arms.
  std::span<const uint32_t> arm_versions() const;
  // The sample of the last EndFrame.
  const FrameSample& last_sample() const;
  // What the shadow lane has done. Any thread.
  ShadowStats shadow_stats() const;

 private:
  friend class AdaptiveFactory;
  class Impl;
  explicit AdaptiveBroadPhase(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace sweepstake
