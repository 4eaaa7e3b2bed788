// One game's decisions: frames in, rewards to posteriors, posteriors to switch commands (steps 8
// and 9 of the one path).
//
// Deterministic: the same setup and the same calls give the same decisions bit for bit on every
// platform. Time and randomness come in as arguments. Not thread-safe; distinct sessions are
// independent. Memory is bounded by the number of arms. Decision times come from the caller's
// clock, settling and warm-up from the frames' own times.
//
// At a tick: update the posterior, then sample, then gate. What the paper leaves open is settled
// so:
// - Two clocks. Ticks, the cooldown and active time run on now_ns. Settling, warm-up and
//   measuring run on frame time, counted from the end of the first frame of the new switch
//   epoch; paused and loading frames do not count.
// - When a switch counts. ObserveSwitch says so; but clients report a switch only when the new
//   arm has settled, so frames of a later epoch are kept for it as they come, and the first
//   tick or bail-out that finds some takes the switch as executed without waiting for the
//   report. It was executed that much frame time ago, though not before the last event on
//   now_ns; the cooldown and active time count from then.
// - A command that nobody answers. While it is under way no other is issued, but for a
//   bail-out. It counts as lost at the second or a later tick after it, and not before 4 s have
//   passed (SwitchGate::kCommandPatienceNs, whatever the time scale), whose own interval brought
//   frames of the old epoch; the candidate of that tick, or the exploration's arm, may be
//   commanded then. A refused command ends at once. An arm of the exploration is passed over
//   after three commands in vain.
// - The first command. Where no switch was executed yet there is no cooldown to wait for; a
//   session that goes on after a restart (decision_count > 0) does not know when the last one
//   was, and counts from start_ns.
// - Draws. Every AI tick outside the exploration draws and logs a candidate, also where
//   settling frames, no frames or a rejected window hold it back.
// - Exploration. A slot is the warm-up, which replaces settling, and the measured time after
//   it. Ticks in it update the posterior. It ends at the first tick at which its frame time has
//   passed, never for want of frames; the next arm is commanded at that tick. An arm whose turn
//   it is and that is active already needs no command. The tick that ends the last slot starts
//   the observation window and is an ordinary one already: update, sample, gate, with the
//   cooldown counting from the switch to the last arm explored.
// - Bail-outs. In the exploration, the arm's slot ends and the next arm is commanded. Else the
//   draw decides, and if it falls on the same arm that stays. A bail-out of an earlier epoch is
//   charged to its arm and commands nothing. Frames over the limit are never in a window: ten
//   observations of 0 are their charge, or none where the arm is excused.
// - Policies differ in what they learn, how they choose and what cooldown they ask for (policy.h);
//   all of the above holds for each of them. One that does not explore begins with an ordinary
//   tick; one that starts from priors takes its first decision at start_ns.
// - A rebuild for a changed object count settles again (not within exploration slots); how
//   counts that change all the time are kept from starving learning is said in arm_run.h.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/decision/audit_log.h"
#include "server/decision/options.h"
#include "server/decision/types.h"

namespace sweepstake::decision {

class ArmRuns;

inline constexpr uint32_t kMaxArms = 32;
inline constexpr double kLargestEvidence = 1e15;  // of a prior's alpha and beta

struct SessionSetup {
  DecisionOptions options;
  std::vector<std::string> arms;  // 1–kMaxArms, unique, not empty
  std::vector<BetaPosterior>
      priors;  // as many as arms; empty: Beta(1,1) each. Both parameters in (0, kLargestEvidence)
  uint64_t seed = 1;  // of the exploration order and of all draws
  Mode mode = Mode::kAi;
  uint32_t active_arm = 0;
  uint32_t switch_epoch = 0;
  int64_t start_ns = 0;
  // For a session that goes on after a restart: arms explored already, and decisions taken already.
  uint32_t explored_arm_count = 0;
  uint64_t decision_count = 0;
};

// What is wrong with the setup, one line; absent when it is valid.
std::optional<std::string> Validate(const SessionSetup& setup);

class DecisionSession {
 public:
  // REQUIRES: !Validate(setup).
  explicit DecisionSession(SessionSetup setup);
  ~DecisionSession();
  DecisionSession(DecisionSession&&) noexcept;
  DecisionSession& operator=(DecisionSession&&) noexcept;

  // From here on the sink gets a row per event and decision, beginning with the setup's
  // (audit_log.h). It must outlive the session. Without it nothing is made. Cost: some 3 µs a
  // decision with 7 arms. REQUIRES: nothing was observed yet.
  void StartAudit(AuditSink& sink, AuditOrigin origin);
  // In the place of the frames since the last event, where a log is derived again. False, and
  // nothing changed: another arm or switch epoch is active. REQUIRES: of this session's arms.
  bool RestoreRuns(const ArmRuns& runs);

  // Folds frames into the window of the running tick. Frames of another switch epoch or arm than
  // the active one, settling frames, frames flagged paused or loading, and frames over the bail-out
  // limit are counted and left out. Frames of a later epoch than the active one begin that epoch's
  // settling (see above).
  void ObserveFrames(std::span<const Frame> frames);

  // A frame over the limit, at once (paper §6.3). Frames whose detection is under half of the
  // frame, that are flagged paused or loading, or that are neither over options.bail_out_ns nor
  // flagged kFrameBailOut, are recorded and not blamed: no increment, no command. At most one per
  // frame index is the caller's to keep. The frame may come through ObserveFrames as well.
  Decision ObserveBailOut(const Frame& frame, int64_t now_ns);

  // What the shadow lane measured; learnt at the next tick, in AI mode. The latest kShadowSampleMax
  // since the last tick are kept. Samples of an arm that is not there, or without a finite cost,
  // are left out.
  static constexpr size_t kShadowSampleMax = 256;
  void ObserveShadow(std::span<const ShadowSample> samples);
  // What the scene looks like; the latest since the last tick is learnt at the next one.
  void ObserveDescriptor(const SceneDescriptor& descriptor);

  // The client's answer to a command, or a local switch (command_id 0): the new arm is active from
  // this epoch on. To be called for executed switches only. A report of what is active already
  // changes nothing but what the switch cost; one of an earlier epoch changes nothing.
  // REQUIRES: arm < arms.
  void ObserveSwitch(uint32_t arm, uint32_t switch_epoch, SwitchReason reason, int64_t now_ns,
                     const SwitchCost& cost = {});

  // The client did not execute this command. Only the latest one matters: the next tick may command
  // again.
  void ObserveRefusal(uint64_t command_id);

  // The window begins anew; the exploration goes on where it was.
  // REQUIRES: arm < arms.
  void SetMode(Mode mode, uint32_t active_arm, int64_t now_ns);

  // When the next tick is due: one decision interval after the last was due or, where that has
  // passed too, after the last.
  int64_t next_tick_ns() const;
  // Update, then sample, then gate. A late tick is one tick, never several.
  // REQUIRES: now_ns >= next_tick_ns().
  Decision Tick(int64_t now_ns);

  std::span<const BetaPosterior> posteriors() const;
  // Of the latest tick or bail-out; the policy's, and kDegraded where the frame rate says so
  // (frame_rate_floor.h).
  const Diagnosis& diagnosis() const;
  // The policy's own name, where "default" was asked for.
  std::string_view policy() const;
  uint32_t active_arm() const;
  Mode mode() const;
  bool exploring() const;
  uint32_t explored_arm_count() const;
  uint64_t decision_count() const;
  const SessionCounts& counts() const;
  ObservationSummary observation(int64_t now_ns) const;
  const std::vector<std::string>& arms() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sweepstake::decision
