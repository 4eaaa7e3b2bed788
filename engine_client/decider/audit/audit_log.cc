#include "engine_client/decider/audit/audit_log.h"

#include <bit>
#include <memory>
#include <utility>

#include "engine_client/decider/session/decision_session.h"

namespace sweepstake::decision {
namespace {

// Hashes fields: a number as the eight bytes of its value, a text or list after its length, an
// optional after one number that is 1 if it is present.
class FieldHash {
 public:
  explicit FieldHash(uint64_t before) : hash_(before) {}

  template <typename T>
  void operator()(std::string_view name, const T& value) {
    if constexpr (AuditStruct<const T>) {
      VisitFields(value, *this);
    } else if constexpr (kIsOptional<T>) {
      Add(value ? 1 : 0);
      if (value) (*this)(name, *value);
    } else if constexpr (kIsList<T>) {
      Add(value.size());
      for (const auto& item : value) (*this)(name, item);
    } else if constexpr (std::same_as<T, std::string>) {
      Add(value.size());
      hash_ = math::Fnv1a(hash_, value);
    } else if constexpr (std::same_as<T, double>) {
      Add(std::bit_cast<uint64_t>(value));
    } else {
      Add(static_cast<uint64_t>(value));
    }
  }

  uint64_t hash() const { return hash_; }

 private:
  void Add(uint64_t number) {
    for (const uint64_t word : {number, number >> 32})
      hash_ = math::Fnv1aOfWord(hash_, static_cast<uint32_t>(word));
  }

  uint64_t hash_;
};

// Makes the rows of one session and passes them to the sink. One call of the session makes a
// decision's row: OnTick or OnBailOut begins it with the inputs, OnDecision completes it.
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
  void Begin(AuditKind kind, std::optional<int64_t> now_ns, std::optional<ArmRuns> runs = {});
  void End();

  AuditSink& sink_;
  const std::string session_id_;
  const uint32_t segment_;
  const std::vector<std::string> arms_;
  const PolicyKind& policy_;
  const uint32_t reward_version_;
  uint64_t row_count_ = 0;
  uint64_t hash_ = math::kFnv1aStart;
  // One row object per thread, shared by all its sessions. Each row is completed before the next
  // begins.
  static thread_local AuditRow row_;
};

thread_local AuditRow AuditRecorder::row_;

AuditRecorder::AuditRecorder(AuditSink& sink, AuditOrigin origin, const SessionSetup& setup,
                             const PolicyKind& policy)
    : sink_(sink),
      session_id_(origin.session_id),
      segment_(origin.segment),
      arms_(setup.arms),
      policy_(policy),
      reward_version_(RewardVersionOf(policy, setup.options.weights)) {
  Begin(AuditKind::kSetup, setup.start_ns);
  row_.setup = {std::move(origin), setup};
  // Log the policy's own name, because the meaning of "default" may change in a later version.
  row_.setup->setup.options.policy = policy.name;
  End();
}

void AuditRecorder::OnSwitch(const SwitchReport& report, const ArmRuns& runs) {
  Begin(AuditKind::kSwitch, report.now_ns, runs);
  row_.arm = arms_[report.arm];
  row_.reason = report.reason;
  row_.switch_epoch = report.switch_epoch;
  row_.switch_cost = report.cost;
  End();
}

void AuditRecorder::OnRefusal(uint64_t command_id) {
  Begin(AuditKind::kRefusal, std::nullopt);
  row_.command_id = command_id;
  End();
}

void AuditRecorder::OnMode(Mode mode, uint32_t active_arm, int64_t now_ns, const ArmRuns& runs) {
  Begin(AuditKind::kMode, now_ns, runs);
  row_.arm = arms_[active_arm];
  row_.mode = mode;
  End();
}

void AuditRecorder::OnOrder(const OrderReport& order) {
  Begin(AuditKind::kOrder, order.now_ns);
  row_.operator_name = order.operator_name;
  if (order.arm) row_.arm = arms_[*order.arm];
  row_.mode = order.mode;
  End();
}

void AuditRecorder::OnTick(const TickInput& input, const ArmRuns& runs) {
  Begin(AuditKind::kTick, input.now_ns, runs);
  row_.shadow.assign(input.shadow_samples.begin(), input.shadow_samples.end());
  row_.scene = input.descriptor;
}

void AuditRecorder::OnBailOut(const FrameSample& frame, int64_t now_ns, const ArmRuns& runs) {
  Begin(AuditKind::kBailOut, now_ns, runs);
  row_.frame = frame;
}

void AuditRecorder::OnDecision(const Decision& decision) {
  const DecisionRecord& record = decision.record;
  const Diagnosis& diagnosis = record.diagnosis;
  if (decision.command) {
    row_.command_id = decision.command->command_id;
    row_.arm = arms_[decision.command->arm];
    row_.reason = decision.command->reason;
  }
  const bool is_learnt = !diagnosis.best_probability.empty();
  row_.decision = {.id = record.decision_id,
                   .policy = std::string(policy_.name),
                   .reward_version = reward_version_,
                   .active_arm = arms_[record.active_arm],
                   .candidate = record.candidate ? arms_[*record.candidate] : "",
                   .outcome = record.outcome,
                   .reward = record.reward,
                   .increment = decision.increment,
                   .posteriors = record.posteriors,
                   .draws = record.draws,
                   .best_probability = diagnosis.best_probability,
                   .leader = is_learnt ? arms_[diagnosis.leader] : "",
                   .expected_loss_ratio = is_learnt ? diagnosis.expected_loss_ratio : 0,
                   .entropy = is_learnt ? diagnosis.entropy : 0,
                   .verdict = diagnosis.verdict,
                   .gate = record.gate,
                   .propensity = record.propensity};
  End();
}

void AuditRecorder::Begin(AuditKind kind, std::optional<int64_t> now_ns,
                          std::optional<ArmRuns> runs) {
  row_ = {.session = session_id_,
          .segment = segment_,
          .row = ++row_count_,
          .kind = kind,
          .time_ns = now_ns,
          .runs = std::move(runs)};
}

void AuditRecorder::End() {
  row_.log_hash = hash_ = AuditHash(hash_, row_);
  sink_.OnAuditRow(row_);
}

}  // namespace

uint64_t AuditHash(uint64_t before, const AuditRow& row) {
  FieldHash hash(before);
  VisitHashedFields(row, hash);
  return hash.hash();
}

AuditRow MissingRow(std::string_view session_id, uint32_t segment, uint64_t row) {
  return {.session = std::string(session_id),
          .segment = segment,
          .row = row,
          .kind = AuditKind::kMissing};
}

AuditRow AdminRows::Next(int64_t now_ns, int64_t unix_ms, std::string operator_name,
                         std::string action) {
  AuditRow row{.session = std::string(kAdminSession),
               .segment = segment_,
               .row = ++row_count_,
               .kind = AuditKind::kAdmin,
               .time_ns = now_ns,
               .operator_name = std::move(operator_name),
               .unix_ms = unix_ms,
               .action = std::move(action)};
  row.log_hash = hash_ = AuditHash(hash_, row);
  return row;
}

void StartAudit(DecisionSession& session, AuditSink& sink, AuditOrigin origin) {
  session.SetObserver(std::make_unique<AuditRecorder>(sink, std::move(origin), session.setup(),
                                                      session.policy_kind()));
}

}  // namespace sweepstake::decision
