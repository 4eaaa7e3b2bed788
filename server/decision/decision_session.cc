#include "server/decision/decision_session.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "server/decision/arm_runs.h"
#include "server/decision/audit_recorder.h"
#include "server/decision/exploration.h"
#include "server/decision/frame_rate_floor.h"
#include "server/decision/math/saturating_sum.h"
#include "server/decision/observation.h"
#include "server/decision/policy/policy.h"
#include "server/decision/safeguards.h"

namespace sweepstake::decision {
namespace {

std::vector<BetaPosterior> PriorsOf(const SessionSetup& setup) {
  return setup.priors.empty() ? std::vector<BetaPosterior>(setup.arms.size()) : setup.priors;
}

std::optional<int64_t> LastSwitchOf(const SessionSetup& setup) {
  return setup.decision_count > 0 ? std::optional(setup.start_ns) : std::nullopt;
}

std::unique_ptr<Policy> PolicyOf(const SessionSetup& setup) {
  return MakePolicy({.options = setup.options,
                     .arms = setup.arms,
                     .priors = PriorsOf(setup),
                     .has_priors = !setup.priors.empty()});
}

// The first decision of a session that knows something already waits for no frame.
bool StartsFromPriors(const SessionSetup& setup) {
  return PolicyKindOf(setup.options.policy).starts_from_priors && !setup.priors.empty();
}

int64_t FirstTickOf(const SessionSetup& setup) {
  return StartsFromPriors(setup)
             ? setup.start_ns
             : SaturatingSum(setup.start_ns, setup.options.decision_interval_ns);
}

uint32_t ArmCount(const SessionSetup& setup) { return static_cast<uint32_t>(setup.arms.size()); }

}  // namespace

class DecisionSession::Impl {
 public:
  explicit Impl(SessionSetup setup);

  void StartAudit(AuditSink& sink, AuditOrigin origin) {
    audit_ = std::make_unique<AuditRecorder>(sink, std::move(origin), setup_);
  }
  bool RestoreRuns(const ArmRuns& runs);
  void ObserveFrame(const Frame& frame);
  Decision ObserveBailOut(const Frame& frame, int64_t now_ns);
  void ObserveShadow(const ShadowSample& sample);
  void ObserveDescriptor(const SceneDescriptor& descriptor) { descriptor_ = descriptor; }
  void ObserveSwitch(uint32_t arm, uint32_t switch_epoch, SwitchReason reason, int64_t now_ns,
                     const SwitchCost& cost);
  void ObserveRefusal(uint64_t command_id);
  void SetMode(Mode mode, uint32_t active_arm, int64_t now_ns);
  Decision Tick(int64_t now_ns);

  bool exploring() const {
    return setup_.options.explore && policy_kind_.explores && !exploration_.done();
  }
  const SessionSetup& setup() const { return setup_; }
  const Policy& policy() const { return *policy_; }
  const PolicyKind& policy_kind() const { return policy_kind_; }
  const Diagnosis& diagnosis() const { return diagnosis_; }
  const ArmRun& run() const { return runs_.active(); }
  Mode mode() const { return mode_; }
  const Exploration& exploration() const { return exploration_; }
  const Observation& observation() const { return observation_; }
  const SessionCounts& counts() const { return counts_; }
  uint64_t decision_count() const { return decision_count_; }
  int64_t next_tick_ns() const { return next_tick_ns_; }

 private:
  // Frames.
  void CountRebuild(const Frame& frame);

  // Switches.
  uint64_t SettlingOfNewRun() const;
  void AdoptLaterRun(int64_t now_ns);
  void Activate(const ArmRun& run, SwitchReason reason, int64_t now_ns);

  // The parts of a decision.
  void ScheduleNextTick(int64_t now_ns);
  Decision Open(int64_t now_ns);
  Decision Close(Decision decision);
  void Diagnose(std::optional<double> fps);
  void Explore(Decision& decision);
  void GoOnExploring(Decision& decision, SwitchReason reason);
  void EndSlot(int64_t now_ns);
  void LearnScene(int64_t now_ns);
  std::optional<Outcome> Learn(Decision& decision);
  std::optional<Outcome> Choose(DecisionRecord& record, bool bailed_out) const;
  void SampleAndGate(Decision& decision, std::optional<Outcome> hold);
  Outcome Gate(const DecisionRecord& record, std::optional<Outcome> hold,
               std::optional<Outcome> own_hold) const;
  void Blame(const Frame& frame, Decision& decision);
  void Resample(Decision& decision);
  void Command(Decision& decision, uint32_t arm, SwitchReason reason);
  void RecordTick(int64_t now_ns);

  // Whatever frames change here and decisions depend on is in runs_, which is what the audit log
  // holds of them.
  const SessionSetup setup_;
  const PolicyKind& policy_kind_;
  const std::unique_ptr<Policy> policy_;
  Diagnosis diagnosis_;
  FrameRateFloor frame_rate_floor_;
  Exploration exploration_;
  SwitchGate gate_;
  Observation observation_;
  SessionCounts counts_;

  Mode mode_;
  ArmRuns runs_;
  bool run_reported_ = true;  // by ObserveSwitch, or from the setup
  SwitchReason commanded_reason_ = SwitchReason::kPolicy;

  std::vector<ShadowSample> shadow_samples_;   // since the last tick
  std::optional<SceneDescriptor> descriptor_;  // the latest since then

  int64_t next_tick_ns_;
  int64_t last_tick_ns_;
  int64_t last_event_ns_;
  uint64_t decision_count_;
  uint64_t command_count_;
  std::unique_ptr<AuditRecorder> audit_;  // null: nobody asked for a log
};

DecisionSession::Impl::Impl(SessionSetup setup)
    : setup_(std::move(setup)),
      policy_kind_(PolicyKindOf(setup_.options.policy)),
      policy_(PolicyOf(setup_)),
      frame_rate_floor_(setup_.options.fps_floor, ArmCount(setup_)),
      exploration_(setup_.seed, ArmCount(setup_), setup_.explored_arm_count),
      gate_(LastSwitchOf(setup_)),
      observation_(setup_.arms.size(), setup_.active_arm),
      mode_(setup_.mode),
      runs_(ArmCount(setup_), ArmRun(setup_.active_arm, setup_.switch_epoch, SettlingOfNewRun())),
      next_tick_ns_(FirstTickOf(setup_)),
      last_tick_ns_(setup_.start_ns),
      last_event_ns_(setup_.start_ns),
      decision_count_(setup_.decision_count),
      command_count_(setup_.decision_count) {
  if (!exploring()) observation_.Start(setup_.start_ns);
}

bool DecisionSession::Impl::RestoreRuns(const ArmRuns& runs) {
  const ArmRun& active = runs.active();
  if (active.arm() != run().arm() || active.switch_epoch() != run().switch_epoch()) return false;
  runs_ = runs;
  return true;
}

void DecisionSession::Impl::ObserveFrame(const Frame& frame) {
  ArmRun* run = runs_.Find(frame, SettlingOfNewRun());
  if (run == nullptr) {
    ++counts_.other_epoch_frame_count;
    return;
  }
  if ((frame.flags & (kFramePaused | kFrameLoading)) != 0) {
    ++counts_.suspended_frame_count;
  } else if (IsOverBailOutLimit(frame, setup_.options.bail_out_ns)) {
    ++counts_.over_limit_frame_count;
    run->Pass(frame);
  } else {
    CountRebuild(frame);
    const int64_t rebuild_settling_ns = exploring() ? 0 : setup_.options.settling_ns;
    const bool measured = run->Observe(frame, static_cast<uint64_t>(rebuild_settling_ns));
    ++(measured ? counts_.measured_frame_count : counts_.settling_frame_count);
  }
}

void DecisionSession::Impl::CountRebuild(const Frame& frame) {
  if ((frame.flags & kFrameRebuild) == 0) return;
  ++counts_.rebuild_frame_count;
  counts_.rebuild_detection_time_ns =
      SaturatingSum(counts_.rebuild_detection_time_ns, frame.detection_time_ns);
}

uint64_t DecisionSession::Impl::SettlingOfNewRun() const {
  const DecisionOptions& options = setup_.options;
  return static_cast<uint64_t>(exploring() ? options.exploration_warm_up_ns : options.settling_ns);
}

void DecisionSession::Impl::ObserveShadow(const ShadowSample& sample) {
  if (sample.arm >= setup_.arms.size() || sample.detection_time_ns == 0) return;
  if (shadow_samples_.size() == kShadowSampleMax) shadow_samples_.erase(shadow_samples_.begin());
  shadow_samples_.push_back(sample);
}

void DecisionSession::Impl::ObserveSwitch(uint32_t arm, uint32_t switch_epoch, SwitchReason reason,
                                          int64_t now_ns, const SwitchCost& cost) {
  assert(arm < setup_.arms.size());
  if (audit_) audit_->RecordSwitch(arm, switch_epoch, reason, now_ns, cost, runs_);
  AdoptLaterRun(now_ns);
  // An epoch that has ended already: frames of the one after it were faster than this report.
  if (IsLaterEpoch(run().switch_epoch(), switch_epoch)) return;
  if (run().arm() == arm && run().switch_epoch() == switch_epoch) {
    if (!run_reported_) observation_.CorrectReason(reason);
  } else {
    Activate(ArmRun(arm, switch_epoch, SettlingOfNewRun()), reason, now_ns);
  }
  run_reported_ = true;
  if (mode_ == Mode::kAi) policy_->LearnSwitchCost(arm, cost);
}

void DecisionSession::Impl::AdoptLaterRun(int64_t now_ns) {
  if (runs_.later()) {
    const ArmRun later = *runs_.later();
    Activate(later, commanded_reason_, now_ns);
    run_reported_ = false;
  }
  last_event_ns_ = std::max(last_event_ns_, now_ns);
}

void DecisionSession::Impl::Activate(const ArmRun& run, SwitchReason reason, int64_t now_ns) {
  const uint64_t since_last_event =
      now_ns > last_event_ns_
          ? static_cast<uint64_t>(now_ns) - static_cast<uint64_t>(last_event_ns_)
          : 0;
  const uint64_t age_ns = std::min(run.elapsed_ns(), since_last_event);
  const int64_t executed_ns = static_cast<int64_t>(static_cast<uint64_t>(now_ns) - age_ns);
  gate_.OnExecuted(executed_ns);
  observation_.Activate(run.arm(), reason, executed_ns);
  runs_.Activate(run);
}

void DecisionSession::Impl::ObserveRefusal(uint64_t command_id) {
  if (audit_) audit_->RecordRefusal(command_id);
  if (command_id == command_count_) gate_.OnRefused();
}

void DecisionSession::Impl::SetMode(Mode mode, uint32_t active_arm, int64_t now_ns) {
  assert(active_arm < setup_.arms.size());
  if (audit_) audit_->RecordMode(mode, active_arm, now_ns, runs_);
  AdoptLaterRun(now_ns);
  mode_ = mode;
  runs_.ClearWindow();
  if (active_arm != run().arm()) {
    Activate(ArmRun(active_arm, run().switch_epoch(), SettlingOfNewRun()), SwitchReason::kManual,
             now_ns);
  }
}

Decision DecisionSession::Impl::Tick(int64_t now_ns) {
  assert(now_ns >= next_tick_ns_);
  if (audit_) RecordTick(now_ns);
  ScheduleNextTick(now_ns);
  AdoptLaterRun(now_ns);
  gate_.OnTick(runs_.active_frames_seen(), now_ns);
  Decision decision = Open(now_ns);
  if (mode_ == Mode::kManual) {
    decision.record.outcome = Outcome::kManual;
  } else {
    LearnScene(now_ns);
    if (exploring()) {
      Explore(decision);
    } else {
      const std::optional<Outcome> hold = Learn(decision);
      SampleAndGate(decision, hold);
    }
  }
  Diagnose(run().window().empty() ? std::nullopt : std::optional(run().window().Metrics().fps));
  shadow_samples_.clear();
  descriptor_.reset();
  runs_.ClearWindow();
  last_tick_ns_ = now_ns;
  return Close(std::move(decision));
}

void DecisionSession::Impl::RecordTick(int64_t now_ns) {
  if (mode_ == Mode::kAi) {
    audit_->BeginTick(now_ns, runs_, shadow_samples_, descriptor_);
  } else {
    audit_->BeginTick(now_ns, runs_, {}, std::nullopt);
  }
}

// What is known of the scene beyond the active arm's window.
void DecisionSession::Impl::LearnScene(int64_t now_ns) {
  if (descriptor_) policy_->LearnDescriptor(*descriptor_, now_ns);
  if (!shadow_samples_.empty()) policy_->LearnShadow(shadow_samples_, now_ns);
}

void DecisionSession::Impl::ScheduleNextTick(int64_t now_ns) {
  const int64_t interval_ns = setup_.options.decision_interval_ns;
  const int64_t due_ns = SaturatingSum(next_tick_ns_, interval_ns);
  next_tick_ns_ = due_ns > now_ns ? due_ns : SaturatingSum(now_ns, interval_ns);
}

Decision DecisionSession::Impl::Open(int64_t now_ns) {
  Decision decision;
  decision.record.decision_id = ++decision_count_;
  decision.record.time_ns = now_ns;
  decision.record.active_arm = run().arm();
  return decision;
}

Decision DecisionSession::Impl::Close(Decision decision) {
  decision.record.posteriors = policy_->posteriors();
  decision.record.context = policy_->context();
  decision.record.diagnosis = diagnosis_;
  if (audit_) audit_->EndDecision(decision);
  return decision;
}

// `fps`: of the active arm, where there is something new.
void DecisionSession::Impl::Diagnose(std::optional<double> fps) {
  diagnosis_ = policy_->Diagnose();
  if (diagnosis_.best_probability.empty()) return;
  if (fps) frame_rate_floor_.Observe(run().arm(), *fps, diagnosis_.leader);
  if (frame_rate_floor_.degraded()) diagnosis_.verdict = Verdict::kDegraded;
}

std::optional<Outcome> DecisionSession::Impl::Learn(Decision& decision) {
  if (run().window().empty()) {
    const bool first = decision.record.decision_id == setup_.decision_count + 1;
    if (first && StartsFromPriors(setup_)) return std::nullopt;
    return run().settling_frames_seen() ? Outcome::kHeldSettling : Outcome::kNoFrames;
  }
  const std::optional<Lesson> lesson = policy_->LearnWindow(
      {.arm = run().arm(), .window = run().window(), .now_ns = decision.record.time_ns});
  if (!lesson) return Outcome::kRejected;
  decision.increment = lesson->increment;
  decision.record.reward = lesson->reward;
  return std::nullopt;
}

// Returns why the policy itself would not switch to its candidate.
std::optional<Outcome> DecisionSession::Impl::Choose(DecisionRecord& record,
                                                     bool bailed_out) const {
  Choice choice = policy_->Choose({.active_arm = run().arm(),
                                   .seed = setup_.seed,
                                   .decision_id = record.decision_id,
                                   .now_ns = record.time_ns,
                                   .last_tick_ns = last_tick_ns_,
                                   .last_switch_ns = gate_.last_switch_ns(),
                                   .start_ns = setup_.start_ns,
                                   .bailed_out = bailed_out});
  record.candidate = choice.candidate;
  record.draws = std::move(choice.draws);
  record.gate = choice.gate;
  record.propensity = choice.propensity;
  return choice.hold;
}

// `hold`: what keeps a candidate back whatever it is; `own_hold`: what the policy has against it.
void DecisionSession::Impl::SampleAndGate(Decision& decision, std::optional<Outcome> hold) {
  const std::optional<Outcome> own_hold = Choose(decision.record, false);
  decision.record.outcome = Gate(decision.record, hold, own_hold);
  if (decision.record.outcome == Outcome::kSwitched) {
    Command(decision, *decision.record.candidate, SwitchReason::kPolicy);
  }
}

Outcome DecisionSession::Impl::Gate(const DecisionRecord& record, std::optional<Outcome> hold,
                                    std::optional<Outcome> own_hold) const {
  if (hold) return *hold;
  if (record.candidate == run().arm()) return Outcome::kKept;
  if (gate_.switch_under_way()) return Outcome::kHeldSettling;
  if (own_hold) return *own_hold;
  const int64_t cooldown_ns = policy_->cooldown_ns().value_or(setup_.options.cooldown_ns);
  return gate_.CooldownPassed(record.time_ns, cooldown_ns) ? Outcome::kSwitched
                                                           : Outcome::kHeldCooldown;
}

void DecisionSession::Impl::Command(Decision& decision, uint32_t arm, SwitchReason reason) {
  decision.command = SwitchCommand{.command_id = ++command_count_, .arm = arm, .reason = reason};
  decision.record.reason = reason;
  commanded_reason_ = reason;
  gate_.OnCommand(decision.record.time_ns);
}

void DecisionSession::Impl::Explore(Decision& decision) {
  decision.record.outcome = Outcome::kExploring;
  std::optional<Outcome> hold;
  if (run().arm() == exploration_.slot_arm()) {
    hold = Learn(decision);
    const auto slot_ns = static_cast<uint64_t>(setup_.options.exploration_warm_up_ns) +
                         static_cast<uint64_t>(setup_.options.exploration_measure_ns);
    if (run().elapsed_ns() >= slot_ns) EndSlot(decision.record.time_ns);
  }
  if (exploring() && !gate_.switch_under_way()) GoOnExploring(decision, SwitchReason::kExploration);
  if (!exploring()) {
    SampleAndGate(decision, hold);
  } else if (hold == Outcome::kRejected) {
    decision.record.outcome = Outcome::kRejected;
  }
}

// Commands the arm whose turn it is, passing over those that were commanded in vain.
void DecisionSession::Impl::GoOnExploring(Decision& decision, SwitchReason reason) {
  while (exploring() && run().arm() != exploration_.slot_arm()) {
    if (exploration_.CountCommand()) {
      Command(decision, exploration_.slot_arm(), reason);
      return;
    }
    EndSlot(decision.record.time_ns);
  }
}

void DecisionSession::Impl::EndSlot(int64_t now_ns) {
  exploration_.EndSlot();
  if (!exploring()) {
    observation_.Start(now_ns);
  } else if (run().arm() == exploration_.slot_arm()) {
    runs_.active().Restart(SettlingOfNewRun());
  }
}

Decision DecisionSession::Impl::ObserveBailOut(const Frame& frame, int64_t now_ns) {
  if (audit_) audit_->BeginBailOut(frame, now_ns, runs_);
  runs_.Find(frame, SettlingOfNewRun());  // begins a later run where the frame shows one
  AdoptLaterRun(now_ns);
  Decision decision = Open(now_ns);
  decision.record.outcome = exploring() ? Outcome::kExploring : Outcome::kKept;
  if (mode_ == Mode::kManual) {
    decision.record.outcome = Outcome::kManual;
  } else if (frame.arm < setup_.arms.size() && BlamesArm(frame, setup_.options.bail_out_ns)) {
    Blame(frame, decision);
  } else {
    ++counts_.excused_bail_out_count;
  }
  const bool charged = decision.increment && runs_.IsActive(frame);
  Diagnose(charged ? std::optional(0.0) : std::nullopt);
  return Close(std::move(decision));
}

void DecisionSession::Impl::Blame(const Frame& frame, Decision& decision) {
  ++counts_.charged_bail_out_count;
  decision.increment = policy_->LearnBailOut(frame.arm);
  if (!runs_.IsActive(frame)) return;
  if (exploring()) {
    if (run().arm() == exploration_.slot_arm()) EndSlot(decision.record.time_ns);
    GoOnExploring(decision, SwitchReason::kBailOut);
  }
  if (!exploring()) Resample(decision);
}

void DecisionSession::Impl::Resample(Decision& decision) {
  Choose(decision.record, true);
  const uint32_t candidate = *decision.record.candidate;
  decision.record.outcome = candidate == run().arm() ? Outcome::kKept : Outcome::kSwitched;
  if (candidate != run().arm()) Command(decision, candidate, SwitchReason::kBailOut);
}

DecisionSession::DecisionSession(SessionSetup setup) {
  assert(!Validate(setup));
  impl_ = std::make_unique<Impl>(std::move(setup));
}
DecisionSession::~DecisionSession() = default;
DecisionSession::DecisionSession(DecisionSession&&) noexcept = default;
DecisionSession& DecisionSession::operator=(DecisionSession&&) noexcept = default;

void DecisionSession::StartAudit(AuditSink& sink, AuditOrigin origin) {
  impl_->StartAudit(sink, std::move(origin));
}
bool DecisionSession::RestoreRuns(const ArmRuns& runs) { return impl_->RestoreRuns(runs); }
void DecisionSession::ObserveFrames(std::span<const Frame> frames) {
  for (const Frame& frame : frames) impl_->ObserveFrame(frame);
}
Decision DecisionSession::ObserveBailOut(const Frame& frame, int64_t now_ns) {
  return impl_->ObserveBailOut(frame, now_ns);
}
void DecisionSession::ObserveShadow(std::span<const ShadowSample> samples) {
  for (const ShadowSample& sample : samples) impl_->ObserveShadow(sample);
}
void DecisionSession::ObserveDescriptor(const SceneDescriptor& descriptor) {
  impl_->ObserveDescriptor(descriptor);
}
void DecisionSession::ObserveSwitch(uint32_t arm, uint32_t switch_epoch, SwitchReason reason,
                                    int64_t now_ns, const SwitchCost& cost) {
  impl_->ObserveSwitch(arm, switch_epoch, reason, now_ns, cost);
}
void DecisionSession::ObserveRefusal(uint64_t command_id) { impl_->ObserveRefusal(command_id); }
void DecisionSession::SetMode(Mode mode, uint32_t active_arm, int64_t now_ns) {
  impl_->SetMode(mode, active_arm, now_ns);
}
int64_t DecisionSession::next_tick_ns() const { return impl_->next_tick_ns(); }
Decision DecisionSession::Tick(int64_t now_ns) { return impl_->Tick(now_ns); }
std::span<const BetaPosterior> DecisionSession::posteriors() const {
  return impl_->policy().posteriors();
}
const Diagnosis& DecisionSession::diagnosis() const { return impl_->diagnosis(); }
std::string_view DecisionSession::policy() const { return impl_->policy_kind().name; }
uint32_t DecisionSession::active_arm() const { return impl_->run().arm(); }
Mode DecisionSession::mode() const { return impl_->mode(); }
bool DecisionSession::exploring() const { return impl_->exploring(); }
uint32_t DecisionSession::explored_arm_count() const {
  return impl_->exploration().explored_arm_count();
}
uint64_t DecisionSession::decision_count() const { return impl_->decision_count(); }
const SessionCounts& DecisionSession::counts() const { return impl_->counts(); }
ObservationSummary DecisionSession::observation(int64_t now_ns) const {
  return impl_->observation().Summary(now_ns);
}
const std::vector<std::string>& DecisionSession::arms() const { return impl_->setup().arms; }

}  // namespace sweepstake::decision
