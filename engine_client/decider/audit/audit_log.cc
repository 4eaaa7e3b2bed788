#include "engine_client/decider/audit/audit_log.h"

#include <charconv>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "engine_client/decider/audit/cell_text.h"
#include "engine_client/decider/audit/cells.h"
#include "engine_client/decider/audit/csv.h"
#include "engine_client/decider/session/decision_session.h"
#include "engine_client/math/hash.h"

namespace sweepstake::decision {
namespace {

// The log names the policy itself, because what "default" stands for may change.
SessionSetup WithPolicyNamed(SessionSetup setup, const PolicyKind& policy) {
  setup.options.policy = policy.name;
  return setup;
}

// Ends a row whose other cells are complete. `hash` is the hash of the segment so far.
void AppendLogHash(std::string& row, uint64_t& hash) {
  hash = math::Fnv1a(hash, row);
  char digits[16];
  const auto end = std::to_chars(digits, digits + sizeof digits, hash, 16);
  row.append(digits, end.ptr);
}

// Makes the rows of one session and hands them to the sink. A decision's row is begun with its
// inputs and ended with the decision, by one call of the session. The buffers are reused: nothing
// is allocated once a row of each length has been made.
class AuditRecorder final : public DecisionObserver {
 public:
  // Records the setup's row.
  AuditRecorder(AuditSink& sink, AuditOrigin origin, const SessionSetup& setup,
                const PolicyKind& policy);

  void OnSwitch(const SwitchReport& report, const ArmRuns& runs) override;
  void OnRefusal(uint64_t command_id) override;
  void OnMode(Mode mode, uint32_t active_arm, int64_t now_ns, const ArmRuns& runs) override;
  void OnOrder(const OrderReport& order) override;
  void OnTick(const TickInput& input, const ArmRuns& runs) override;
  void OnBailOut(const FrameSample& frame, int64_t now_ns, const ArmRuns& runs) override;
  void OnDecision(const Decision& decision) override;

 private:
  void Begin(AuditKind kind, std::optional<int64_t> now_ns);
  void End();
  // Completes the row up to this column and returns it, so that the cell can be appended.
  std::string& Cell(AuditColumn column);
  template <typename T>
  void Put(AuditColumn column, const T& value);
  void PutText(AuditColumn column, std::string_view text);
  void PutArm(AuditColumn column, uint32_t arm) { PutText(column, arms_[arm]); }
  void PutRuns(const ArmRuns& runs);
  template <typename Item, typename ValueOf>
  void PutList(AuditColumn column, std::span<const Item> items, ValueOf value_of);
  void PutCommand(const SwitchCommand& command);
  void PutVersions();
  void PutRecord(const DecisionRecord& record);
  void PutIncrement(const Increment& increment);
  void PutDiagnosis(const Diagnosis& diagnosis);
  void PutGate(const GateTerms& gate);

  AuditSink& sink_;
  const AuditOrigin origin_;
  const std::vector<std::string> arms_;
  const PolicyKind& policy_;
  const uint64_t seed_;

  uint64_t row_count_ = 0;
  uint64_t hash_;
  // Shared by all sessions of a thread: a row is always ended before the next one begins.
  static thread_local std::string row_;
  static thread_local std::string text_;  // the text of a cell that may need quotes
  size_t column_ = 0;                     // the column at the row's end
};

thread_local std::string AuditRecorder::row_;
thread_local std::string AuditRecorder::text_;

AuditRecorder::AuditRecorder(AuditSink& sink, AuditOrigin origin, const SessionSetup& setup,
                             const PolicyKind& policy)
    : sink_(sink),
      origin_(std::move(origin)),
      arms_(setup.arms),
      policy_(policy),
      seed_(setup.seed),
      hash_(math::kFnv1aStart) {
  Begin(AuditKind::kSetup, setup.start_ns);
  text_.clear();
  AppendSetup(text_, WithPolicyNamed(setup, policy), origin_);
  AppendCsv(Cell(AuditColumn::kSetup), text_);
  PutVersions();
  End();
}

void AuditRecorder::OnSwitch(const SwitchReport& report, const ArmRuns& runs) {
  Begin(AuditKind::kSwitch, report.now_ns);
  PutRuns(runs);
  if (report.cost.ended_trial) Put(AuditColumn::kFrame, FieldsOf(*report.cost.ended_trial));
  PutArm(AuditColumn::kArm, report.arm);
  AppendName(Cell(AuditColumn::kReason), kSwitchReasonNames, report.reason);
  Put(AuditColumn::kSwitchEpoch, report.switch_epoch);
  Put(AuditColumn::kRebuildTimeNs, report.cost.rebuild_time_ns);
  Put(AuditColumn::kSettlingCostNs, report.cost.settling_cost_ns);
  End();
}

void AuditRecorder::OnRefusal(uint64_t command_id) {
  Begin(AuditKind::kRefusal, std::nullopt);
  Put(AuditColumn::kCommandId, command_id);
  End();
}

void AuditRecorder::OnMode(Mode mode, uint32_t active_arm, int64_t now_ns, const ArmRuns& runs) {
  Begin(AuditKind::kMode, now_ns);
  PutRuns(runs);
  PutArm(AuditColumn::kArm, active_arm);
  AppendName(Cell(AuditColumn::kMode), kModeNames, mode);
  End();
}

void AuditRecorder::OnOrder(const OrderReport& order) {
  Begin(AuditKind::kOrder, order.now_ns);
  text_.assign(kOperatorKey).append(order.operator_name);
  PutText(AuditColumn::kSetup, text_);
  if (order.arm) PutArm(AuditColumn::kArm, *order.arm);
  AppendName(Cell(AuditColumn::kMode), kModeNames, order.mode);
  End();
}

void AuditRecorder::OnTick(const TickInput& input, const ArmRuns& runs) {
  Begin(AuditKind::kTick, input.now_ns);
  PutRuns(runs);
  PutList(AuditColumn::kShadow, input.shadow_samples,
          [](const ShadowSample& sample) { return FieldsOf(sample); });
  if (input.descriptor) Put(AuditColumn::kDescriptor, FieldsOf(*input.descriptor));
}

void AuditRecorder::OnBailOut(const FrameSample& frame, int64_t now_ns, const ArmRuns& runs) {
  Begin(AuditKind::kBailOut, now_ns);
  PutRuns(runs);
  Put(AuditColumn::kFrame, FieldsOf(frame));
}

void AuditRecorder::OnDecision(const Decision& decision) {
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
  AppendLogHash(row, hash_);
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
  PutText(AuditColumn::kPolicy, policy_.name);
  Put(AuditColumn::kVersionOfReward, policy_.reward_version);
  PutText(AuditColumn::kProgramVersion, origin_.program_version);
  Put(AuditColumn::kSeed, seed_);
}

void AuditRecorder::PutRecord(const DecisionRecord& record) {
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

}  // namespace

std::string AuditHeader() {
  std::string header;
  for (const std::string_view name : kAuditColumnNames)
    header.append(header.empty() ? "" : ",").append(name);
  return header;
}

std::string MissingRow(std::string_view session_id, uint32_t segment, uint64_t row) {
  std::string text;
  AppendCsv(text, session_id);
  AppendText(text += ',', segment);
  AppendText(text += ',', row);
  AppendName(text += ',', kAuditKindNames, AuditKind::kMissing);
  return text.append(kAuditColumnNames.size() - 4, ',');
}

AdminRows::AdminRows(uint32_t segment) : segment_(segment), hash_(math::kFnv1aStart) {}

std::string AdminRows::Next(int64_t now_ns, int64_t unix_ms, std::string_view action,
                            std::string_view who) {
  std::string row(kAdminSession);
  AppendText(row += ',', segment_);
  AppendText(row += ',', ++row_count_);
  AppendName(row += ',', kAuditKindNames, AuditKind::kAdmin);
  AppendText(row += ',', now_ns);
  std::string text = "unix_ms=";
  AppendText(text, unix_ms);
  AppendEscaped(text += ';', action);
  AppendEscaped(text.append(";").append(kOperatorKey), who);
  AppendCsv(row += ',', text);
  row.append(kAuditColumnNames.size() - static_cast<size_t>(AuditColumn::kSetup) - 1, ',');
  AppendLogHash(row, hash_);
  return row;
}

void StartAudit(DecisionSession& session, AuditSink& sink, AuditOrigin origin) {
  session.SetObserver(std::make_unique<AuditRecorder>(sink, std::move(origin), session.setup(),
                                                      session.policy_kind()));
}

}  // namespace sweepstake::decision
