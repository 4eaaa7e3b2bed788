#include "engine_client/decider/session/decision_session.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "engine_client/decider/policy/log_cost.h"
#include "engine_client/math/saturating_sum.h"

namespace sweepstake::decision {
namespace {

std::vector<BetaPosterior> PriorsOf(const SessionSetup& setup) {
  return setup.priors.empty() ? std::vector<BetaPosterior>(setup.arms.size()) : setup.priors;
}

std::vector<std::string> StoredRegimesOf(const RegimePriors& priors) {
  return {priors.buckets.begin(), priors.buckets.begin() + priors.stored_count};
}

std::optional<int64_t> LastSwitchOf(const SessionSetup& setup) {
  return setup.decision_count > 0 ? std::optional(setup.start_ns) : std::nullopt;
}

std::unique_ptr<Policy> PolicyOf(const SessionSetup& setup, PolicyRegistry policies) {
  return MakePolicy({.options = setup.options,
                     .arms = setup.arms,
                     .priors = PriorsOf(setup),
                     .regime_priors = setup.regime_priors,
                     .has_priors = !setup.priors.empty(),
                     .stops_trials = setup.stops_trials},
                    policies);
}

FrameRateFloor::Times TimesOf(const Window& window) {
  const WindowMetrics metrics = window.Metrics();
  return {.frame_ms = 1e3 / metrics.fps, .detection_ms = metrics.detection_ms};
}

FrameRateFloor::Times TimesOf(const FrameSample& frame) {
  return {.frame_ms = 1e-6 * static_cast<double>(frame.frame_time_ns),
          .detection_ms = 1e-6 * static_cast<double>(frame.detection_time_ns)};
}

// Returns whether the session can decide before the first frame, because it has priors.
bool StartsFromPriors(const SessionSetup& setup, const PolicyKind& kind) {
  return kind.starts_from_priors && !setup.priors.empty();
}

int64_t FirstTickOf(const SessionSetup& setup, const PolicyKind& kind) {
  return StartsFromPriors(setup, kind)
             ? setup.start_ns
             : SaturatingSum(setup.start_ns, setup.options.decision_interval_ns);
}

uint32_t ArmCount(const SessionSetup& setup) { return static_cast<uint32_t>(setup.arms.size()); }

SessionSetup Resolved(SessionSetup setup, const PolicyKind& kind) {
  setup.options = OptionsFor(kind, std::move(setup.options));
  return setup;
}

}  // namespace

DecisionSession::DecisionSession(SessionSetup setup, PolicyRegistry policies)
    : policy_kind_(PolicyKindOf(setup.options.policy, policies)),
      setup_(Resolved(std::move(setup), policy_kind_)),
      policy_(PolicyOf(setup_, policies)),
      stored_regimes_(StoredRegimesOf(setup_.regime_priors)),
      standings_(setup_.arms.size()),
      frame_rate_floor_(setup_.options.fps_floor, ArmCount(setup_)),
      exploration_(setup_.seed, ArmCount(setup_), setup_.explored_arm_count),
      gate_(LastSwitchOf(setup_)),
      bail_out_budget_(setup_.options.bail_out_ns, setup_.start_ns),
      observation_(setup_.arms.size(), setup_.active_arm),
      tally_(setup_.arms.size()),
      mode_(setup_.mode),
      runs_(ArmCount(setup_), ArmRun(setup_.active_arm, setup_.switch_epoch, SettlingOfNewRun())),
      next_tick_ns_(FirstTickOf(setup_, policy_kind_)),
      last_tick_ns_(setup_.start_ns),
      last_event_ns_(setup_.start_ns),
      decision_count_(setup_.decision_count),
      command_count_(setup_.decision_count) {
  assert(!Validate(setup_, policies));
  if (!exploring()) observation_.Start(setup_.start_ns);
}

bool DecisionSession::waits_for_frames() const {
  return decision_count_ == 0 && !StartsFromPriors(setup_, policy_kind_);
}

void DecisionSession::ObserveFrames(std::span<const FrameSample> frames) {
  for (const FrameSample& frame : frames) ObserveFrame(frame);
}

bool DecisionSession::RestoreRuns(const ArmRuns& runs) {
  const ArmRun& active = runs.active();
  if (active.arm() != run().arm() || active.switch_epoch() != run().switch_epoch()) return false;
  if (runs.later() && runs.later()->arm() >= arms().size()) return false;
  runs_.Restore(runs);
  return true;
}

void DecisionSession::ObserveFrame(const FrameSample& frame) {
  runs_.regime_span().ObserveFrame(frame.frame_index);
  ArmRun* run = runs_.Find(frame, SettlingOfNewRun());
  if (run == nullptr) {
    ++counts_.other_epoch_frame_count;
    return;
  }
  if ((frame.flags & kFrameWithoutCost) != 0) {
    ++counts_.costless_frame_count;
  } else if (IsOverBailOutLimit(frame, setup_.options.bail_out_ns)) {
    ++counts_.over_limit_frame_count;
    run->Pass(frame);
  } else {
    CountRebuild(frame);
    const int64_t rebuild_settling_ns = exploring() ? 0 : setup_.options.settling_ns;
    const bool measured = run->Observe(frame, static_cast<uint64_t>(rebuild_settling_ns));
    ++(measured ? counts_.measured_frame_count : counts_.settling_frame_count);
    if (measured) tally_.AddFrame(frame, *policy_);
  }
}

void DecisionSession::CountRebuild(const FrameSample& frame) {
  if ((frame.flags & kFrameRebuild) == 0) return;
  ++counts_.rebuild_frame_count;
  counts_.rebuild_detection_time_ns =
      SaturatingSum(counts_.rebuild_detection_time_ns, frame.detection_time_ns);
}

uint64_t DecisionSession::SettlingOfNewRun() const {
  const DecisionOptions& options = setup_.options;
  return static_cast<uint64_t>(exploring() ? options.exploration_warm_up_ns : options.settling_ns);
}

void DecisionSession::ObserveShadow(std::span<const ShadowSample> samples) {
  for (const ShadowSample& sample : samples) {
    if (sample.arm >= setup_.arms.size() || sample.detection_time_ns == 0) continue;
    if (shadow_samples_.size() == kMaxShadowSamples) shadow_samples_.erase(shadow_samples_.begin());
    shadow_samples_.push_back(sample);
  }
}

void DecisionSession::ObserveSwitch(uint32_t arm, uint32_t switch_epoch, SwitchReason reason,
                                    int64_t now_ns, const SwitchCost& cost) {
  assert(arm < setup_.arms.size());
  assert(!cost.ended_trial || cost.ended_trial->arm < setup_.arms.size());
  if (observer_) observer_->OnSwitch({arm, switch_epoch, reason, now_ns, cost}, runs_);
  AdoptLaterRun(now_ns);
  const bool learns = mode_ == Mode::kAi;
  if (learns && cost.ended_trial) policy_->LearnTrialEnd(*cost.ended_trial, arm, now_ns);
  // Ignore the report if its epoch has already ended: frames of a later one arrived first.
  if (IsLaterEpoch(run().switch_epoch(), switch_epoch)) return;
  if (run().arm() == arm && run().switch_epoch() == switch_epoch) {
    if (!run_reported_) observation_.CorrectReason(reason);
  } else {
    Activate(ArmRun(arm, switch_epoch, SettlingOfNewRun()), reason, now_ns);
  }
  run_reported_ = true;
  if (learns && !cost.ended_trial) policy_->LearnSwitchCost(arm, cost);
  tally_.AddSwitchCost(cost, *policy_);
}

void DecisionSession::AdoptLaterRun(int64_t now_ns) {
  if (runs_.later()) {
    const ArmRun later = *runs_.later();
    Activate(later, commanded_reason_, now_ns);
    run_reported_ = false;
  }
  last_event_ns_ = std::max(last_event_ns_, now_ns);
}

void DecisionSession::Activate(const ArmRun& run, SwitchReason reason, int64_t now_ns) {
  const uint64_t since_last_event =
      now_ns > last_event_ns_
          ? static_cast<uint64_t>(now_ns) - static_cast<uint64_t>(last_event_ns_)
          : 0;
  const uint64_t age_ns = std::min(run.elapsed_ns(), since_last_event);
  const int64_t executed_ns = static_cast<int64_t>(static_cast<uint64_t>(now_ns) - age_ns);
  gate_.OnExecuted(executed_ns);
  observation_.Activate(run.arm(), reason, executed_ns);
  tally_.AddSwitch(executed_ns);
  runs_.Activate(run);
}

void DecisionSession::ObserveRefusal(uint64_t command_id) {
  if (observer_) observer_->OnRefusal(command_id);
  if (command_id == command_count_) gate_.OnRefused();
}

void DecisionSession::SetMode(Mode mode, uint32_t active_arm, int64_t now_ns) {
  assert(active_arm < setup_.arms.size());
  if (observer_) observer_->OnMode(mode, active_arm, now_ns, runs_);
  AdoptLaterRun(now_ns);
  mode_ = mode;
  runs_.active().DropNewFrames();
  runs_.ClearWindow();
  if (active_arm != run().arm()) {
    Activate(ArmRun(active_arm, run().switch_epoch(), SettlingOfNewRun()), SwitchReason::kManual,
             now_ns);
  }
}

Decision DecisionSession::Tick(int64_t now_ns) {
  assert(now_ns >= next_tick_ns());
  if (observer_) observer_->OnTick({now_ns, shadow_samples_, descriptor_}, runs_);
  ScheduleNextTick(now_ns);
  AdoptLaterRun(now_ns);
  gate_.OnTick(runs_.active_frames_seen(), now_ns);
  const bool regime_ends = runs_.regime_span().has_ended();
  if (run().window().empty() && !runs_.regime_span().is_in_doubt()) runs_.active().FileNewFrames();
  Decision decision = Open(now_ns);
  // If the regime ends, the evidence since the last tick belongs to it, and the descriptor to the
  // next one.
  if (!regime_ends) LearnDescriptor(now_ns);
  LearnVisits(decision);
  const bool chooses = mode_ == Mode::kAi && !exploring();
  const std::optional<DecisionOutcome> hold = chooses ? Learn(decision) : std::nullopt;
  if (decision.increment || !decision.lane_increments.empty()) decision.regime = PresentBucket();
  if (regime_ends) LearnDescriptor(now_ns);
  if (!runs_.regime_span().is_in_doubt()) tally_.File(*policy_);
  if (chooses) {
    SampleAndGate(decision, hold);
  } else if (mode_ == Mode::kManual) {
    decision.record.outcome = DecisionOutcome::kManual;
  } else {
    TickExploration(decision);
  }
  Diagnose(window_is_evidence() ? std::optional(TimesOf(run().window())) : std::nullopt);
  shadow_samples_.clear();
  descriptor_.reset();
  runs_.ClearWindow();
  last_tick_ns_ = now_ns;
  return Close(std::move(decision));
}

void DecisionSession::ObserveDescriptor(const SceneDescriptor& descriptor) {
  descriptor_ = descriptor;
  if (!policy_kind_.keeps_regimes) return;
  const DescriptorMatch match = policy_->Match(descriptor);
  runs_.ObserveDescriptor(match);
  if (match == DescriptorMatch::kPresent && !runs_.regime_span().is_in_doubt())
    tally_.File(*policy_);
}

int64_t DecisionSession::next_tick_ns() const {
  if (!runs_.regime_span().has_ended()) return next_tick_ns_;
  const int64_t early_ns = SaturatingSum(last_tick_ns_, setup_.options.decision_interval_ns / 4);
  return std::min(next_tick_ns_, early_ns);
}

// Learns from the lane's visits to frames of the present regime. The policy learns in manual mode
// too, but nothing becomes stored evidence.
void DecisionSession::LearnVisits(Decision& decision) {
  std::erase_if(shadow_samples_, [&](const ShadowSample& sample) {
    return !runs_.regime_span().Contains(sample.first_frame_index);
  });
  if (shadow_samples_.empty()) return;
  std::vector<Increment> increments =
      policy_->LearnShadow(shadow_samples_, decision.record.time_ns);
  // Drop visits beyond the number that a lane can make in one interval.
  std::vector<uint32_t> counts(setup_.arms.size());
  std::erase_if(increments,
                [&](const Increment& visit) { return ++counts[visit.arm] > kMaxVisitsPerTick; });
  for (const Increment& visit : increments) ++standings_[visit.arm].lane_visit_count;
  if (mode_ == Mode::kAi) decision.lane_increments = std::move(increments);
}

// Learns from the scene descriptor. A descriptor in doubt may be a mixture of two regimes.
void DecisionSession::LearnDescriptor(int64_t now_ns) {
  RegimeSpan& span = runs_.regime_span();
  if (descriptor_ && (span.has_ended() || !span.is_in_doubt()))
    policy_->LearnDescriptor(*descriptor_, now_ns);
  if (span.has_ended()) span.BeginNext();
}

// Returns the bucket in which evidence of the present regime is stored. It is empty if the scene
// has too many regimes and none is similar.
std::string DecisionSession::PresentBucket() {
  const RegimeFeatures features = policy_->present_features();
  std::string bucket = BucketOf(features);
  if (bucket.empty()) return bucket;
  if (const auto nearest = NearestOf(stored_regimes_, features, /*limit=*/1))
    return stored_regimes_[*nearest];
  if (stored_regimes_.size() >= kMaxStoredRegimes) return {};
  return stored_regimes_.emplace_back(bucket);
}

void DecisionSession::ScheduleNextTick(int64_t now_ns) {
  const int64_t interval_ns = setup_.options.decision_interval_ns;
  const int64_t due_ns = SaturatingSum(next_tick_ns_, interval_ns);
  next_tick_ns_ = SaturatingSum(now_ns, interval_ns);
  if (due_ns > now_ns) next_tick_ns_ = std::min(next_tick_ns_, due_ns);
}

Decision DecisionSession::Open(int64_t now_ns) {
  Decision decision;
  decision.record.decision_id = ++decision_count_;
  decision.record.time_ns = now_ns;
  decision.record.active_arm = run().arm();
  return decision;
}

void DecisionSession::UpdateStandings() {
  const std::vector<BetaPosterior>& posteriors = policy_->posteriors();
  const bool is_diagnosed = !diagnosis_.best_probability.empty();
  const bool has_ratios = is_diagnosed && policy_->ExpectedLogCost(diagnosis_.leader);
  for (uint32_t arm = 0; arm < standings_.size(); ++arm) {
    ArmStanding& standing = standings_[arm];
    const double evidence = std::max(posteriors[arm].evidence() - BetaPosterior().evidence(), 0.0);
    standing.effective_window_count = evidence / policy_->WindowEvidence(arm);
    standing.best_probability = is_diagnosed ? diagnosis_.best_probability[arm] : 0;
    standing.cost_ratio.reset();
    if (!has_ratios || !policy_->ExpectedLogCost(arm)) continue;
    standing.cost_ratio = arm == diagnosis_.leader
                              ? CostRatio{}
                              : CostRatioOf(posteriors[arm], posteriors[diagnosis_.leader]);
  }
}

SceneReport DecisionSession::Report() const {
  SavingBaselines baselines = {.initial = setup_.initial_arm};
  const auto found = std::find(arms().begin(), arms().end(), kReferenceArm);
  if (found != arms().end()) baselines.reference = static_cast<uint32_t>(found - arms().begin());
  return ReportOf(policy_->Regimes(), tally_.uses(), tally_.total(), diagnosis_, baselines);
}

Decision DecisionSession::Close(Decision decision) {
  // The diagnosis is of the same posteriors as the draws.
  if (policy_kind_.draws_from_posteriors && !decision.record.draws.empty()) {
    decision.record.propensity =
        PropensityOfDraw(diagnosis_, *decision.record.candidate, setup_.arms.size());
  }
  decision.record.posteriors = policy_->posteriors();
  decision.record.diagnosis = diagnosis_;
  UpdateStandings();
  decision.record.standings = standings_;
  decision.record.saved_us = saved_us();
  if (observer_) observer_->OnDecision(decision);
  return decision;
}

// Updates the diagnosis. `times` are those of the active arm, or absent if there is no new window.
void DecisionSession::Diagnose(const std::optional<FrameRateFloor::Times>& times) {
  diagnosis_ = policy_->Diagnose();
  diagnosis_.verdict = verdict_.Observe(diagnosis_.verdict);
  if (diagnosis_.best_probability.empty()) return;
  if (times) frame_rate_floor_.Observe(run().arm(), *times, diagnosis_.leader);
  if (frame_rate_floor_.degraded()) diagnosis_.verdict = Verdict::kDegraded;
}

// Returns whether the policy learns from the window. A policy whose rewards measure costs ignores a
// window without a search.
bool DecisionSession::window_is_evidence() const {
  const Window& window = run().window();
  return !window.empty() && (!policy_kind_.goes_by_cost() || window.shows_cost());
}

std::optional<DecisionOutcome> DecisionSession::Learn(Decision& decision) {
  if (!window_is_evidence()) {
    const bool first = decision.record.decision_id == setup_.decision_count + 1;
    if (first && StartsFromPriors(setup_, policy_kind_)) return std::nullopt;
    return run().settling_frames_seen() ? DecisionOutcome::kHeldSettling
                                        : DecisionOutcome::kNoFrames;
  }
  const std::optional<WindowUpdate> update = policy_->LearnWindow(
      {.arm = run().arm(), .window = run().window(), .now_ns = decision.record.time_ns});
  if (!update) return DecisionOutcome::kRejected;
  ++standings_[run().arm()].live_window_count;
  decision.increment = update->increment;
  decision.record.reward = update->reward;
  return std::nullopt;
}

// Gets a candidate from the policy and records its choice. Returns the reason if the policy itself
// holds the switch back.
std::optional<DecisionOutcome> DecisionSession::Choose(DecisionRecord& record,
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
  record.trial_limit_percent = choice.trial_limit_percent;
  return choice.hold;
}

// Gets a candidate from the policy, and commands a switch if the gate lets it pass. `hold`, if set,
// is the session's reason not to switch to any candidate.
void DecisionSession::SampleAndGate(Decision& decision, std::optional<DecisionOutcome> hold) {
  const std::optional<DecisionOutcome> own_hold = Choose(decision.record, false);
  decision.record.outcome = Gate(decision.record, hold, own_hold);
  if (decision.record.outcome == DecisionOutcome::kSwitched) {
    Command(decision, *decision.record.candidate, SwitchReason::kPolicy);
  }
}

DecisionOutcome DecisionSession::Gate(const DecisionRecord& record,
                                      std::optional<DecisionOutcome> hold,
                                      std::optional<DecisionOutcome> own_hold) const {
  if (hold) return *hold;
  if (record.candidate == run().arm()) return DecisionOutcome::kKept;
  if (gate_.switch_under_way()) return DecisionOutcome::kHeldSettling;
  if (own_hold) return *own_hold;
  const int64_t cooldown_ns = policy_->cooldown_ns().value_or(setup_.options.cooldown_ns);
  return gate_.CooldownPassed(record.time_ns, cooldown_ns) ? DecisionOutcome::kSwitched
                                                           : DecisionOutcome::kHeldCooldown;
}

void DecisionSession::Command(Decision& decision, uint32_t arm, SwitchReason reason) {
  decision.command = SwitchCommand{.command_id = ++command_count_,
                                   .arm = arm,
                                   .reason = reason,
                                   .trial_limit_percent = decision.record.trial_limit_percent};
  decision.record.reason = reason;
  commanded_reason_ = reason;
  gate_.OnCommand(decision.record.time_ns);
}

void DecisionSession::TickExploration(Decision& decision) {
  decision.record.outcome = DecisionOutcome::kExploring;
  std::optional<DecisionOutcome> hold;
  if (run().arm() == exploration_.slot_arm()) {
    hold = Learn(decision);
    const auto slot_ns = static_cast<uint64_t>(setup_.options.exploration_warm_up_ns) +
                         static_cast<uint64_t>(setup_.options.exploration_measure_ns);
    if (run().elapsed_ns() >= slot_ns) EndSlot(decision.record.time_ns);
  }
  if (exploring() && !gate_.switch_under_way())
    CommandNextSlot(decision, SwitchReason::kExploration);
  if (!exploring()) {
    SampleAndGate(decision, hold);
  } else if (hold == DecisionOutcome::kRejected) {
    decision.record.outcome = DecisionOutcome::kRejected;
  }
}

// Commands a switch to the next arm of the exploration. Skips an arm after kMaxCommands commands
// without effect.
void DecisionSession::CommandNextSlot(Decision& decision, SwitchReason reason) {
  while (exploring() && run().arm() != exploration_.slot_arm()) {
    if (exploration_.CountCommand()) {
      Command(decision, exploration_.slot_arm(), reason);
      return;
    }
    EndSlot(decision.record.time_ns);
  }
}

void DecisionSession::EndSlot(int64_t now_ns) {
  exploration_.EndSlot();
  if (!exploring()) {
    observation_.Start(now_ns);
  } else if (run().arm() == exploration_.slot_arm()) {
    runs_.active().Restart(SettlingOfNewRun());
  }
}

Decision DecisionSession::ObserveBailOut(const FrameSample& frame, int64_t now_ns) {
  if (observer_) observer_->OnBailOut(frame, now_ns, runs_);
  runs_.Find(frame, SettlingOfNewRun());  // begins a later run if the frame shows one
  AdoptLaterRun(now_ns);
  Decision decision = Open(now_ns);
  decision.record.outcome = exploring() ? DecisionOutcome::kExploring : DecisionOutcome::kKept;
  if (mode_ == Mode::kManual) {
    decision.record.outcome = DecisionOutcome::kManual;
  } else if (IsCharged(frame)) {
    Blame(frame, decision);
  } else {
    ++counts_.excused_bail_out_count;
  }
  const bool charged = decision.increment && runs_.IsActive(frame);
  Diagnose(charged ? std::optional(TimesOf(frame)) : std::nullopt);
  return Close(std::move(decision));
}

bool DecisionSession::IsCharged(const FrameSample& frame) const {
  if (mode_ != Mode::kAi || frame.arm >= setup_.arms.size()) return false;
  const int64_t limit_ns = setup_.options.bail_out_ns;
  return policy_kind_.counts_any_cause ? IsOverBailOutLimit(frame, limit_ns)
                                       : IsCausedByArm(frame, limit_ns);
}

void DecisionSession::Blame(const FrameSample& frame, Decision& decision) {
  ++counts_.charged_bail_out_count;
  // The session always learns from the bail-out, so the game leaves the arm even if the report is
  // false. Whether the bail-out is also stored as evidence is limited below.
  const Increment increment = policy_->LearnBailOut(frame.arm);
  const bool may_be_evidence = (frame.flags & kFrameNoEvidence) == 0;
  if (may_be_evidence && bail_out_budget_.Spend(decision.record.time_ns)) {
    decision.increment = increment;
    decision.regime = PresentBucket();
  } else {
    ++counts_.surplus_bail_out_count;
  }
  if (!runs_.IsActive(frame)) return;
  if (exploring()) {
    if (run().arm() == exploration_.slot_arm()) EndSlot(decision.record.time_ns);
    CommandNextSlot(decision, SwitchReason::kBailOut);
  }
  if (!exploring()) Resample(decision);
}

void DecisionSession::Resample(Decision& decision) {
  Choose(decision.record, true);
  const uint32_t candidate = *decision.record.candidate;
  decision.record.outcome =
      candidate == run().arm() ? DecisionOutcome::kKept : DecisionOutcome::kSwitched;
  if (candidate != run().arm()) Command(decision, candidate, SwitchReason::kBailOut);
}

}  // namespace sweepstake::decision
