// One game's decisions: from frames to rewards and posteriors, and from posteriors to switch
// commands.
//
// Deterministic: the same setup and the same calls give the same decisions bit for bit on every
// platform. Time and randomness are arguments. Not thread-safe; distinct sessions are independent.
// The memory is bounded by the number of arms.
//
// A tick first updates the posterior, then samples a candidate, then gates it. The paper leaves the
// following open:
//
// - Two clocks. Ticks, the cooldown and active time use now_ns, the caller's clock. Settling,
//   warm-up and measuring use frame time, which counts from the end of the first frame of the new
//   switch epoch. Paused and loading frames do not count.
// - When a switch counts as executed. ObserveSwitch reports it, but clients report a switch only
//   when the new arm has settled. Frames of a later epoch are therefore kept as they come. The
//   first tick or bail-out that finds some treats the switch as executed without waiting for the
//   report. It was executed that much frame time ago, but not before the last event on now_ns. The
//   cooldown and active time count from then.
// - A command without an answer. While a command is under way, no other one is issued, except after
//   a bail-out. When it counts as lost (SwitchGate in safeguards.h), the candidate of that tick, or
//   the exploration's arm, may be commanded. A refused command ends at once. The exploration skips
//   an arm after three commands without effect.
// - The first command. Before the first executed switch no cooldown runs. A session that continues
//   after a restart (decision_count > 0) does not know when the last switch was, and counts from
//   start_ns.
// - Draws. Every AI tick outside the exploration draws and logs a candidate, also if settling
//   frames, missing frames or a rejected window hold it back.
// - Exploration. A slot is the warm-up, which replaces settling, and the measured time after it.
//   Ticks in a slot update the posterior. The slot ends at the first tick at which its frame time
//   has passed, never because frames are missing. The next arm is commanded at that tick. An arm
//   that is active when its turn comes needs no command. The tick that ends the last slot starts
//   the observation window and is already an ordinary one: update, sample, gate, with the cooldown
//   counting from the switch to the last arm explored.
// - Bail-outs. In the exploration the arm's slot ends and the next arm is commanded. Otherwise the
//   draw decides; if it falls on the same arm, that arm stays. A bail-out of an earlier epoch is
//   charged to its arm and commands nothing. Frames over the limit are never in a window: they are
//   charged with the penalty, or not charged if the arm is excused. Bail-outs beyond BailOutBudget
//   (safeguards.h) and those with kFrameNoEvidence change the session like others, but have no
//   increment.
// - Policies differ in what they learn, how they choose and which cooldown they ask for (policy.h);
//   all rules above hold for each of them. A policy that does not explore begins with an ordinary
//   tick. A policy that starts from priors takes its first decision at start_ns.
// - A rebuild because of a changed object count settles again, except within exploration slots
//   (ArmRun::Observe in arm_runs.h).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine_client/decider/session/arm_runs.h"
#include "engine_client/decider/session/decision_observer.h"
#include "engine_client/decider/session/policy_registry.h"
#include "engine_client/decider/session/run_phases.h"
#include "engine_client/decider/session/safeguards.h"
#include "engine_client/decider/session/session_setup.h"
#include "engine_client/decider/types.h"

namespace sweepstake::decision {

class DecisionSession {
 public:
  // The policy is looked up in `policies`. REQUIRES: !Validate(setup, policies).
  explicit DecisionSession(SessionSetup setup, PolicyRegistry policies);
  DecisionSession(const DecisionSession&) = delete;
  DecisionSession& operator=(const DecisionSession&) = delete;

  // From now on reports every event and decision to the observer. REQUIRES: nothing was observed
  // yet.
  void SetObserver(std::unique_ptr<DecisionObserver> observer) { observer_ = std::move(observer); }
  // Replaces the frames since the last event by their summary when a log is derived again. Returns
  // false and changes nothing if another arm or switch epoch is active, or if the later run is of
  // no arm of this session.
  bool RestoreRuns(const ArmRuns& runs);

  // Adds frames to the window of the current tick. Frames of another switch epoch or arm than the
  // active one, settling frames, paused or loading frames, and frames over the bail-out limit are
  // counted and left out. Frames of a later epoch than the active one begin that epoch's settling
  // (see above).
  void ObserveFrames(std::span<const FrameSample> frames);

  // Takes a frame over the limit at once (paper §6.3). A frame is recorded but not blamed, with no
  // increment and no command, if it is neither over options.bail_out_ns nor flagged kFrameBailOut,
  // and, unless the policy is `paper`, if detection is under half of it or if it is paused or
  // loading. The frame may also come through ObserveFrames. REQUIRES: called at most once per frame
  // index.
  Decision ObserveBailOut(const FrameSample& frame, int64_t now_ns);
  // Returns whether a bail-out with this frame, at this time, is evidence unless it has
  // kFrameNoEvidence.
  bool IsEvidence(const FrameSample& frame, int64_t now_ns) const {
    return IsCharged(frame) && bail_out_budget_.HasRoom(now_ns);
  }

  // Takes samples of the shadow lane, which the next tick learns from, in manual mode too. The
  // latest kMaxShadowSamples samples since the last tick are kept. Samples of an unknown arm or
  // without a cost are ignored.
  static constexpr size_t kMaxShadowSamples = 256;
  // Maximum lane visits per arm and tick that count as evidence.
  static constexpr uint32_t kMaxVisitsPerTick = 8;
  void ObserveShadow(std::span<const ShadowSample> samples);
  // Takes a descriptor of the scene. The next tick learns from the latest one.
  void ObserveDescriptor(const SceneDescriptor& descriptor) { descriptor_ = descriptor; }

  // Takes an executed switch, either the client's answer to a command or a local one: the new arm
  // is active from this epoch on. A report of the active epoch only updates the switch cost. A
  // report of an earlier epoch changes nothing. The end of a trial is always learnt, instead of a
  // cost. REQUIRES: arm < arms, and that of a trial.
  void ObserveSwitch(uint32_t arm, uint32_t switch_epoch, SwitchReason reason, int64_t now_ns,
                     const SwitchCost& cost = {});

  // Takes a command that the client refused. If it was the latest one, the next tick may command
  // again.
  void ObserveRefusal(uint64_t command_id);

  // Begins a new window; the exploration continues where it was. REQUIRES: arm < arms.
  void SetMode(Mode mode, uint32_t active_arm, int64_t now_ns);

  // Reports the order to the observer, and changes nothing. REQUIRES: order.arm < arms, if any.
  void ObserveOrder(const OrderReport& order) {
    if (observer_) observer_->OnOrder(order);
  }

  // The next tick is due one decision interval after the last one was due or, if that time has
  // passed too, after the last one was made.
  int64_t next_tick_ns() const { return next_tick_ns_; }
  // Returns whether the first decision is still to come and waits for frames, because no priors are
  // known.
  bool waits_for_frames() const;
  // Updates, samples and gates. A late tick is one tick, never several.
  // REQUIRES: now_ns >= next_tick_ns().
  Decision Tick(int64_t now_ns);

  std::span<const BetaPosterior> posteriors() const { return policy_->posteriors(); }
  // The policy's diagnosis at the latest tick or bail-out. Its verdict is kDegraded if the frame
  // rate demands it (FrameRateFloor in safeguards.h).
  const Diagnosis& diagnosis() const { return diagnosis_; }
  // The standing of each arm at the latest tick or bail-out.
  std::span<const ArmStanding> standings() const { return standings_; }
  // The policy that "default" stands for.
  const PolicyKind& policy_kind() const { return policy_kind_; }
  std::string_view policy() const { return policy_kind_.name; }
  const SessionSetup& setup() const { return setup_; }
  const std::vector<std::string>& arms() const { return setup_.arms; }
  uint32_t active_arm() const { return run().arm(); }
  Mode mode() const { return mode_; }
  bool exploring() const {
    return setup_.options.explore && policy_kind_.explores && !exploration_.done();
  }
  uint32_t explored_arm_count() const { return exploration_.explored_arm_count(); }
  uint64_t decision_count() const { return decision_count_; }
  const SessionCounts& counts() const { return counts_; }
  ObservationSummary observation(int64_t now_ns) const { return observation_.Summary(now_ns); }

 private:
  const ArmRun& run() const { return runs_.active(); }

  // Frames.
  void ObserveFrame(const FrameSample& frame);
  void CountRebuild(const FrameSample& frame);

  // Switches.
  uint64_t SettlingOfNewRun() const;
  void AdoptLaterRun(int64_t now_ns);
  void Activate(const ArmRun& run, SwitchReason reason, int64_t now_ns);

  // The steps of a decision.
  void ScheduleNextTick(int64_t now_ns);
  Decision Open(int64_t now_ns);
  Decision Close(Decision decision);
  void LearnScene(Decision& decision);
  // Returns whether the policy's rewards depend on the cost only.
  bool goes_by_cost() const;
  bool window_teaches() const;
  std::optional<DecisionOutcome> Learn(Decision& decision);
  std::optional<DecisionOutcome> Choose(DecisionRecord& record, bool bailed_out) const;
  void SampleAndGate(Decision& decision, std::optional<DecisionOutcome> hold);
  DecisionOutcome Gate(const DecisionRecord& record, std::optional<DecisionOutcome> hold,
                       std::optional<DecisionOutcome> own_hold) const;
  void Command(Decision& decision, uint32_t arm, SwitchReason reason);
  void Diagnose(std::optional<double> fps);
  void UpdateStandings();

  // The exploration.
  void TickExploration(Decision& decision);
  void CommandNextSlot(Decision& decision, SwitchReason reason);
  void EndSlot(int64_t now_ns);

  // Bail-outs.
  bool IsCharged(const FrameSample& frame) const;
  void Blame(const FrameSample& frame, Decision& decision);
  void Resample(Decision& decision);

  // Frames change only runs_ among all that decisions depend on. So observers receive runs_ in
  // place of the frames.
  const SessionSetup setup_;
  const PolicyKind& policy_kind_;
  const std::unique_ptr<Policy> policy_;
  std::unique_ptr<DecisionObserver> observer_;  // may be null
  Diagnosis diagnosis_;
  std::vector<ArmStanding> standings_;
  SteadyVerdict verdict_;
  FrameRateFloor frame_rate_floor_;
  Exploration exploration_;
  SwitchGate gate_;
  BailOutBudget bail_out_budget_;
  ObservationWindow observation_;
  SessionCounts counts_;

  Mode mode_;
  ArmRuns runs_;
  bool run_reported_ = true;  // whether ObserveSwitch or the setup named the active run
  SwitchReason commanded_reason_ = SwitchReason::kPolicy;

  std::vector<ShadowSample> shadow_samples_;   // samples since the last tick
  std::optional<SceneDescriptor> descriptor_;  // the latest one since the last tick

  int64_t next_tick_ns_;
  int64_t last_tick_ns_;
  int64_t last_event_ns_;
  uint64_t decision_count_;
  uint64_t command_count_;
};

}  // namespace sweepstake::decision
