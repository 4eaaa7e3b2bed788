// Passes frames and outcomes of the game to the decision session, and its commands back.
#include "sweepstake/embedded_decider.h"
#include "engine_client/decider/session/policy_registry.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <random>
#include <utility>

#include "engine_client/decider/audit/audit_csv.h"
#include "engine_client/decider/audit/audit_log.h"
#include "engine_client/decider/embedded/decision_conversion.h"
#include "engine_client/decider/embedded/evidence_ledger.h"
#include "engine_client/decider/embedded/priors_file.h"
#include "engine_client/decider/embedded/study_maker.h"
#include "engine_client/decider/pooling/priors_sums.h"
#include "engine_client/decider/session/arm_runs.h"
#include "engine_client/decider/session/decision_session.h"
#include "engine_client/text/names.h"
#include "sweepstake/machine_class.h"

namespace sweepstake {
namespace {

// Converts an interval. A value above the maximum stays above it, so that the validation refuses
// it.
int64_t ToSigned(uint64_t interval_ns) {
  constexpr uint64_t kBeyond = decision::kMaxIntervalNs + 1;
  return static_cast<int64_t>(std::min(interval_ns, kBeyond));
}

decision::DecisionOptions UnscaledOptions(const EmbeddedOptions& options) {
  decision::DecisionOptions unscaled;
  unscaled.policy = options.policy;
  unscaled.decision_interval_ns = ToSigned(options.decision_interval_ns);
  unscaled.cooldown_ns = ToSigned(options.cooldown_ns);
  unscaled.settling_ns = ToSigned(options.settling_ns);
  unscaled.fps_floor = options.fps_floor;
  return unscaled;
}

Status ValidateEmbedded(const EmbeddedOptions& options, size_t arm_count, size_t version_count) {
  const auto invalid = [](std::string message) {
    return Status(StatusCode::kInvalidArgument, std::move(message));
  };
  if (arm_count != version_count) return invalid("arms and arm_versions differ in length");
  if (!(options.time_scale >= 1 && options.time_scale <= 1000)) {
    return invalid("time_scale must be 1 to 1000");
  }
  if (options.mode != Mode::kManual && options.mode != Mode::kAi) {
    return invalid("mode is neither kManual (1) nor kAi (2)");
  }
  const std::vector<std::string> problems = decision::NumberProblems(UnscaledOptions(options));
  if (!problems.empty()) return invalid(problems.front());
  for (const auto& [field, name] :
       {std::pair{"project", &options.project}, {"scene", &options.scene}}) {
    if (!text::IsName(*name)) {
      return invalid(std::string(field) + " must be 1 to 128 bytes without control characters");
    }
  }
  for (const auto& [field, name] : {std::pair{"machine_class", &options.machine_class},
                                    {"build", &options.build},
                                    {"source_id", &options.source_id}}) {
    if (!text::IsOptionalName(*name)) {
      return invalid(std::string(field) + " must be at most 128 bytes without control characters");
    }
  }
  if (options.source_id.starts_with(kSumMark)) {
    return invalid("source_id must not begin with *, as the sums of priors files do");
  }
  return {};
}

// Returns a random name that no other source has.
std::string NewSourceId() {
  std::random_device random;
  std::array<char, 48> name;
  std::snprintf(name.data(), name.size(), "embedded-%08x%08x%08x%08x", random(), random(), random(),
                random());
  return name.data();
}

// Removes records that are in a daemon's quarantine; they do not count in a game either.
std::vector<PriorRecord> WithoutQuarantined(std::vector<PriorRecord> records) {
  std::erase_if(records, [](const PriorRecord& record) { return record.is_quarantined; });
  return records;
}

// Reads the priors from the file and from the text, and unites them.
Result<std::vector<PriorRecord>> ReadPriors(const EmbeddedOptions& options) {
  std::vector<PriorRecord> records;
  if (!options.priors_file.empty()) {
    const std::u8string path(options.priors_file.begin(), options.priors_file.end());
    Result<std::vector<PriorRecord>> read = ReadPriorsFile(path);
    if (!read.ok()) return read;
    records = WithoutQuarantined(std::move(*read));
  }
  if (options.priors_data.empty()) return records;
  Result<std::vector<PriorRecord>> parsed = ParsePriors(options.priors_data);
  if (!parsed.ok()) {
    return Status(parsed.status().code(), "priors_data: " + parsed.status().message());
  }
  return Unite(std::move(records), WithoutQuarantined(std::move(*parsed)));
}

std::string MachineClassOf(const EmbeddedOptions& options) {
  return options.machine_class.empty() ? MachineClass() : options.machine_class;
}

decision::PriorKey PriorKeyOf(const EmbeddedOptions& options, const decision::PolicyKind& policy,
                              std::span<const std::string> arms,
                              std::span<const uint32_t> arm_versions) {
  return {.project = options.project,
          .scene = options.scene,
          .machine_class = MachineClassOf(options),
          .reward_version = policy.reward_version,
          .build = options.build,
          .source = options.source_id.empty() ? NewSourceId() : options.source_id,
          .arms = {arms.begin(), arms.end()},
          .backend_versions = {arm_versions.begin(), arm_versions.end()},
          .compares_sources = policy.starts_from_priors};
}

decision::SessionSetup MakeSetup(const EmbeddedOptions& options, std::span<const std::string> arms,
                                 uint64_t now_ns) {
  decision::SessionSetup setup;
  setup.options = UnscaledOptions(options).Scaled(options.time_scale);
  setup.arms.assign(arms.begin(), arms.end());
  setup.seed = options.seed;
  setup.mode = options.mode;
  setup.start_ns = static_cast<int64_t>(now_ns);
  return setup;
}

decision::AuditOrigin OriginOf(const EmbeddedOptions& options, std::span<const uint32_t> versions) {
  return {.session_id = "embedded",
          .segment = 1,
          .project = options.project,
          .scene = options.scene,
          .machine_class = MachineClassOf(options),
          .program_version = SWEEPSTAKE_VERSION,
          .backend_versions = {versions.begin(), versions.end()},
          .unix_start_ms = 0};
}

}  // namespace

class EmbeddedDecider::Impl : private decision::AuditSink {
 public:
  using OnDecision = std::function<void(const DecisionEvent&)>;

  Impl(decision::SessionSetup setup, decision::PolicyRegistry policies, EvidenceLedger ledger,
       OnDecision on_decision)
      : settling_ns_(static_cast<uint64_t>(setup.options.settling_ns)),
        session_(std::move(setup), policies),
        ledger_(std::move(ledger)),
        on_decision_(std::move(on_decision)) {}

  void StartAudit(std::function<void(std::string_view)> on_audit_row,
                  decision::AuditOrigin origin) {
    on_audit_row_ = std::move(on_audit_row);
    decision::StartAudit(session_, *this, std::move(origin));
  }

  void Observe(std::span<const FrameSample> frames, int64_t now_ns);
  void Observe(const SwitchOutcome& outcome, int64_t now_ns);
  void Observe(std::span<const ShadowSample> samples);
  void Observe(const SceneDescriptor& descriptor);
  void SetMode(Mode mode, uint32_t active_arm, int64_t now_ns);
  std::optional<SwitchCommand> Poll(int64_t now_ns);

  uint64_t settling_ns() const { return settling_ns_; }
  const decision::DecisionSession& session() const { return session_; }
  const EvidenceLedger& ledger() const { return ledger_; }
  const std::optional<DecisionEvent>& last_decision() const { return last_decision_; }

 private:
  void Follow(const decision::Decision& decision);
  void OnAuditRow(const decision::AuditRow& row) override {
    on_audit_row_(decision::AuditLines(row));
  }

  const uint64_t settling_ns_;
  decision::DecisionSession session_;
  EvidenceLedger ledger_;
  const OnDecision on_decision_;
  std::function<void(std::string_view)> on_audit_row_;  // null: no log
  uint32_t latest_epoch_ = 0;                           // latest epoch of all frames and outcomes
  std::optional<SwitchCommand> pending_command_;
  std::optional<DecisionEvent> last_decision_;
};

void EmbeddedDecider::Impl::Observe(std::span<const FrameSample> frames, int64_t now_ns) {
  size_t first = 0;  // index of the first frame that is not yet observed
  for (size_t i = 0; i < frames.size(); ++i) {
    latest_epoch_ = frames[i].switch_epoch;
    if ((frames[i].flags & kFrameBailOut) == 0) continue;
    session_.ObserveFrames(frames.subspan(first, i + 1 - first));
    first = i + 1;
    Follow(session_.ObserveBailOut(frames[i], now_ns));
  }
  session_.ObserveFrames(frames.subspan(first));
}

// The outcome of a switch arrives when the arm has settled, long after the first frame of its
// epoch, and adds the reason. The outcome of an epoch that has ended meanwhile is ignored: it would
// take the session back to that epoch.
void EmbeddedDecider::Impl::Observe(const SwitchOutcome& outcome, int64_t now_ns) {
  if (outcome.executed == 0) return session_.ObserveRefusal(outcome.command_id);
  if (decision::IsLaterEpoch(latest_epoch_, outcome.switch_epoch)) return;
  if (std::max(outcome.arm, outcome.trial_arm) >= session_.arms().size()) return;
  latest_epoch_ = outcome.switch_epoch;
  session_.ObserveSwitch(outcome.arm, outcome.switch_epoch, outcome.reason, now_ns,
                         SwitchCostOf(outcome));
}

void EmbeddedDecider::Impl::Observe(std::span<const ShadowSample> samples) {
  session_.ObserveShadow(samples);
}

void EmbeddedDecider::Impl::Observe(const SceneDescriptor& descriptor) {
  session_.ObserveDescriptor(ToDecision(descriptor));
}

void EmbeddedDecider::Impl::SetMode(Mode mode, uint32_t active_arm, int64_t now_ns) {
  if (active_arm >= session_.arms().size()) return;
  session_.SetMode(mode, active_arm, now_ns);
  if (mode == Mode::kManual) pending_command_.reset();
}

std::optional<SwitchCommand> EmbeddedDecider::Impl::Poll(int64_t now_ns) {
  if (now_ns >= session_.next_tick_ns()) Follow(session_.Tick(now_ns));
  return std::exchange(pending_command_, std::nullopt);
}

// Takes the decision's evidence, and its command, which replaces an earlier one.
void EmbeddedDecider::Impl::Follow(const decision::Decision& decision) {
  ledger_.Add(decision);
  last_decision_ = FromDecision(decision, session_.arms());
  if (on_decision_) on_decision_(*last_decision_);
  if (decision.command) pending_command_ = decision.command;
}

Result<std::unique_ptr<EmbeddedDecider>> EmbeddedDecider::Create(
    const EmbeddedOptions& options, std::span<const std::string> arms,
    std::span<const uint32_t> arm_versions, uint64_t now_ns) {
  return StudyMaker{decision::ShippedPolicies()}.MakeDecider(options, arms, arm_versions, now_ns);
}

Result<std::unique_ptr<EmbeddedDecider>> StudyMaker::MakeDecider(
    const EmbeddedOptions& options, std::span<const std::string> arms,
    std::span<const uint32_t> arm_versions, uint64_t now_ns) const {
  if (Status status = ValidateEmbedded(options, arms.size(), arm_versions.size()); !status.ok()) {
    return status;
  }
  decision::SessionSetup setup = MakeSetup(options, arms, now_ns);
  if (const std::optional<std::string> error = decision::Validate(setup, policies)) {
    return Status(StatusCode::kInvalidArgument, *error);
  }
  Result<std::vector<PriorRecord>> records = ReadPriors(options);
  if (!records.ok()) return records.status();
  EvidenceLedger ledger(
      std::move(*records),
      PriorKeyOf(options, decision::PolicyKindOf(options.policy, policies), arms, arm_versions));
  setup.priors = ledger.prior().posteriors();
  if (const std::optional<std::string> error = decision::Validate(setup, policies)) {
    return Status(StatusCode::kInvalidArgument, *error);
  }
  auto impl = std::make_unique<EmbeddedDecider::Impl>(std::move(setup), policies, std::move(ledger),
                                                      options.on_decision);
  if (options.on_audit_row) impl->StartAudit(options.on_audit_row, OriginOf(options, arm_versions));
  return std::unique_ptr<EmbeddedDecider>(new EmbeddedDecider(std::move(impl)));
}

Result<std::string> EmbeddedDecider::ArmOfPriors(const EmbeddedOptions& options,
                                                 std::span<const std::string> arms,
                                                 std::span<const uint32_t> arm_versions) {
  const auto decider = Create(options, arms, arm_versions, 0);
  if (!decider.ok()) return decider.status();
  std::optional<size_t> best;
  const auto& given = (*decider)->impl_->ledger().prior().evidence;
  const auto mean = [&](size_t arm) { return given[arm].alpha / given[arm].evidence(); };
  for (size_t arm = 0; arm < given.size(); ++arm) {
    if (given[arm].evidence() > 0 && (!best || mean(arm) > mean(*best))) best = arm;
  }
  if (best) return arms[*best];
  return Status(
      StatusCode::kNotFound,
      "the priors have no evidence of scene \"" + options.scene + "\" of project \"" +
          options.project + "\" on machine class \"" + MachineClassOf(options) +
          "\" with these arms; export some from a daemon with `sweepstake priors export`");
}

EmbeddedDecider::EmbeddedDecider(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
EmbeddedDecider::~EmbeddedDecider() = default;

void EmbeddedDecider::Observe(std::span<const FrameSample> frames, uint64_t now_ns) {
  impl_->Observe(frames, static_cast<int64_t>(now_ns));
}
void EmbeddedDecider::Observe(const SwitchOutcome& outcome, uint64_t now_ns) {
  impl_->Observe(outcome, static_cast<int64_t>(now_ns));
}
void EmbeddedDecider::Observe(std::span<const ShadowSample> samples) { impl_->Observe(samples); }
void EmbeddedDecider::Observe(const SceneDescriptor& descriptor) { impl_->Observe(descriptor); }
void EmbeddedDecider::SetMode(Mode mode, uint32_t active_arm, uint64_t now_ns) {
  impl_->SetMode(mode, active_arm, static_cast<int64_t>(now_ns));
}
std::optional<SwitchCommand> EmbeddedDecider::Poll(uint64_t now_ns) {
  return impl_->Poll(static_cast<int64_t>(now_ns));
}

std::string EmbeddedDecider::AuditHeader() { return decision::AuditHeader(); }
uint64_t EmbeddedDecider::settling_ns() const { return impl_->settling_ns(); }
std::vector<ArmBelief> EmbeddedDecider::beliefs() const {
  const decision::DecisionSession& session = impl_->session();
  return FromDecision(session.posteriors(), session.standings(), session.diagnosis(),
                      session.arms());
}
SceneVerdict EmbeddedDecider::verdict() const { return FromDecision(impl_->session().diagnosis()); }
const std::optional<DecisionEvent>& EmbeddedDecider::last_decision() const {
  return impl_->last_decision();
}
uint64_t EmbeddedDecider::decision_count() const { return impl_->session().decision_count(); }
uint64_t EmbeddedDecider::prior_source_count() const {
  return impl_->ledger().prior().source_count;
}
std::string EmbeddedDecider::ExportPriors() const {
  return FormatPriors(impl_->ledger().records());
}

}  // namespace sweepstake
