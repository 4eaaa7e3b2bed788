#include "server/decision/audit_recorder.h"

#include <charconv>
#include <utility>

#include "server/decision/audit_csv.h"
#include "server/decision/audit_fields.h"
#include "server/decision/audit_runs.h"
#include "server/decision/audit_setup.h"
#include "server/decision/audit_text.h"
#include "server/decision/math/hash.h"
#include "server/decision/policy/policy.h"

namespace sweepstake::decision {
namespace {

// What "default" stands for may change; the log names the policy itself.
SessionSetup WithPolicyNamed(SessionSetup setup) {
  setup.options.policy = PolicyKindOf(setup.options.policy).name;
  return setup;
}

}  // namespace

AuditRecorder::AuditRecorder(AuditSink& sink, AuditOrigin origin, const SessionSetup& setup)
    : sink_(sink),
      origin_(std::move(origin)),
      arms_(setup.arms),
      policy_(PolicyKindOf(setup.options.policy).name),
      reward_version_(PolicyKindOf(setup.options.policy).reward_version),
      seed_(setup.seed),
      hash_(math::kFnv1aStart) {
  Begin(AuditKind::kSetup, setup.start_ns);
  text_.clear();
  AppendSetup(text_, WithPolicyNamed(setup), origin_);
  AppendCsv(Cell(AuditColumn::kSetup), text_);
  PutVersions();
  End();
}

void AuditRecorder::RecordSwitch(uint32_t arm, uint32_t switch_epoch, SwitchReason reason,
                                 int64_t now_ns, const SwitchCost& cost, const ArmRuns& runs) {
  Begin(AuditKind::kSwitch, now_ns);
  PutRuns(runs);
  PutArm(AuditColumn::kArm, arm);
  AppendName(Cell(AuditColumn::kReason), kSwitchReasonNames, reason);
  Put(AuditColumn::kSwitchEpoch, switch_epoch);
  Put(AuditColumn::kRebuildTimeNs, cost.rebuild_time_ns);
  Put(AuditColumn::kSettlingCostNs, cost.settling_cost_ns);
  End();
}

void AuditRecorder::RecordRefusal(uint64_t command_id) {
  Begin(AuditKind::kRefusal, std::nullopt);
  Put(AuditColumn::kCommandId, command_id);
  End();
}

void AuditRecorder::RecordMode(Mode mode, uint32_t active_arm, int64_t now_ns,
                               const ArmRuns& runs) {
  Begin(AuditKind::kMode, now_ns);
  PutRuns(runs);
  PutArm(AuditColumn::kArm, active_arm);
  AppendName(Cell(AuditColumn::kMode), kModeNames, mode);
  End();
}

void AuditRecorder::BeginTick(int64_t now_ns, const ArmRuns& runs,
                              std::span<const ShadowSample> samples,
                              const std::optional<SceneDescriptor>& descriptor) {
  Begin(AuditKind::kTick, now_ns);
  PutRuns(runs);
  PutList(AuditColumn::kShadow, samples,
          [](const ShadowSample& sample) { return FieldsOf(sample); });
  if (descriptor) Put(AuditColumn::kDescriptor, FieldsOf(*descriptor));
}

void AuditRecorder::BeginBailOut(const Frame& frame, int64_t now_ns, const ArmRuns& runs) {
  Begin(AuditKind::kBailOut, now_ns);
  PutRuns(runs);
  Put(AuditColumn::kFrame, FieldsOf(frame));
}

void AuditRecorder::EndDecision(const Decision& decision) {
  if (decision.command) PutCommand(*decision.command);
  Put(AuditColumn::kDecisionId, decision.record.decision_id);
  PutVersions();
  PutRecord(decision.record);
  if (decision.increment) PutIncrement(*decision.increment);
  const auto alpha = [](const BetaPosterior& posterior) { return posterior.alpha; };
  const auto beta = [](const BetaPosterior& posterior) { return posterior.beta; };
  PutList(AuditColumn::kAlpha, std::span(decision.record.posteriors), alpha);
  PutList(AuditColumn::kBeta, std::span(decision.record.posteriors), beta);
  PutList(AuditColumn::kDraws, std::span(decision.record.draws), std::identity());
  PutDiagnosis(decision.record.diagnosis);
  if (decision.record.gate) PutGate(*decision.record.gate);
  Put(AuditColumn::kPropensity, decision.record.propensity);
  End();
}

void AuditRecorder::Begin(AuditKind kind, std::optional<int64_t> now_ns) {
  row_.clear();
  column_ = 0;
  PutText(AuditColumn::kSession, origin_.session_id);
  Put(AuditColumn::kSegment, origin_.segment);
  Put(AuditColumn::kRow, ++row_count_);
  AppendName(Cell(AuditColumn::kKind), kAuditKindNames, kind);
  Put(AuditColumn::kTimeNs, now_ns);
}

void AuditRecorder::End() {
  std::string& row = Cell(AuditColumn::kLogHash);
  hash_ = math::Fnv1a(hash_, row);
  char digits[16];
  const auto end = std::to_chars(digits, digits + sizeof digits, hash_, 16);
  row.append(digits, end.ptr);
  sink_.OnAuditRow(row);
}

std::string& AuditRecorder::Cell(AuditColumn column) {
  const auto wanted = static_cast<size_t>(column);
  row_.append(wanted - column_, ',');
  column_ = wanted;
  return row_;
}

template <typename T>
void AuditRecorder::Put(AuditColumn column, const T& value) {
  AppendText(Cell(column), value);
}

void AuditRecorder::PutText(AuditColumn column, std::string_view text) {
  AppendCsv(Cell(column), text);
}

void AuditRecorder::PutRuns(const ArmRuns& runs) { AppendRuns(Cell(AuditColumn::kRuns), runs); }

template <typename Item, typename ValueOf>
void AuditRecorder::PutList(AuditColumn column, std::span<const Item> items, ValueOf value_of) {
  std::string& row = Cell(column);
  for (size_t i = 0; i < items.size(); ++i) {
    if (i > 0) row += ' ';
    AppendText(row, value_of(items[i]));
  }
}

void AuditRecorder::PutCommand(const SwitchCommand& command) {
  Put(AuditColumn::kCommandId, command.command_id);
  PutArm(AuditColumn::kArm, command.arm);
  AppendName(Cell(AuditColumn::kReason), kSwitchReasonNames, command.reason);
}

void AuditRecorder::PutVersions() {
  PutText(AuditColumn::kPolicy, policy_);
  Put(AuditColumn::kVersionOfReward, reward_version_);
  PutText(AuditColumn::kProgramVersion, origin_.program_version);
  Put(AuditColumn::kSeed, seed_);
}

void AuditRecorder::PutRecord(const DecisionRecord& record) {
  PutText(AuditColumn::kContext, record.context);
  PutArm(AuditColumn::kActiveArm, record.active_arm);
  if (record.candidate) PutArm(AuditColumn::kCandidate, *record.candidate);
  AppendName(Cell(AuditColumn::kOutcome), kOutcomeNames, record.outcome);
  Put(AuditColumn::kReward, record.reward);
}

void AuditRecorder::PutIncrement(const Increment& increment) {
  PutArm(AuditColumn::kIncrementArm, increment.arm);
  Put(AuditColumn::kIncrementAlpha, increment.alpha);
  Put(AuditColumn::kIncrementBeta, increment.beta);
  Put(AuditColumn::kIncrementWindowCount, increment.window_count);
  Put(AuditColumn::kIncrementBailOutCount, increment.bail_out_count);
}

void AuditRecorder::PutDiagnosis(const Diagnosis& diagnosis) {
  if (!diagnosis.best_probability.empty()) {
    PutList(AuditColumn::kBestProbability, std::span(diagnosis.best_probability), std::identity());
    PutArm(AuditColumn::kLeader, diagnosis.leader);
    Put(AuditColumn::kExpectedLossRatio, diagnosis.expected_loss_ratio);
    Put(AuditColumn::kEntropy, diagnosis.entropy);
  }
  AppendName(Cell(AuditColumn::kVerdict), kVerdictNames, diagnosis.verdict);
}

void AuditRecorder::PutGate(const GateTerms& gate) {
  Put(AuditColumn::kGain, gate.gain);
  Put(AuditColumn::kLoss, gate.loss);
  Put(AuditColumn::kHorizonS, gate.horizon_s);
  Put(AuditColumn::kCooldownS, gate.cooldown_s);
  Put(AuditColumn::kSwitchCostS, gate.cost_s);
}

}  // namespace sweepstake::decision
