// Passes the game's frames and switch outcomes to the decision session, and the session's commands
// to the game.
#include "sweepstake/embedded_decider.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <random>
#include <utility>

#include "engine_client/broad_phase/host/float_environment.h"
#include "engine_client/decider/audit/audit_csv.h"
#include "engine_client/decider/audit/audit_log.h"
#include "engine_client/decider/embedded/evidence_ledger.h"
#include "engine_client/decider/embedded/priors_file.h"
#include "engine_client/decider/embedded/study_maker.h"
#include "engine_client/decider/pooling/priors_sums.h"
#include "engine_client/decider/session/arm_runs.h"
#include "engine_client/decider/session/decision_session.h"
#include "engine_client/decider/session/policy_registry.h"
#include "engine_client/text/names.h"
#include "sweepstake/machine_class.h"

namespace sweepstake {
namespace {

decision::DecisionOptions UnscaledOptions(const EmbeddedOptions& options) {
  decision::DecisionOptions unscaled;
  unscaled.policy = options.policy;
  unscaled.fps_floor = options.fps_floor;
  return unscaled.With({.weights = options.weights,
                        .decision_interval_ns = options.decision_interval_ns,
                        .cooldown_ns = options.cooldown_ns,
                        .settling_ns = options.settling_ns});
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

// Returns a random name, so that no other source has the same one.
std::string NewSourceId() {
  std::random_device random;
  std::array<char, 48> name;
  std::snprintf(name.data(), name.size(), "embedded-%08x%08x%08x%08x", random(), random(), random(),
                random());
  return name.data();
}

// Removes records that a daemon keeps in quarantine. They do not count in a game either.
std::vector<PriorRecord> WithoutQuarantined(std::vector<PriorRecord> records) {
  std::erase_if(records, [](const PriorRecord& record) { return record.is_quarantined; });
  return records;
}

// Reads the priors from the file and from the text of `options`, and merges them.
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
          .reward_version = decision::RewardVersionOf(policy, options.weights),
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
  setup.initial_arm = options.initial_arm;
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

SceneVerdict FromDecision(const decision::Diagnosis& diagnosis) {
  if (diagnosis.best_probability.empty()) return {};
  return {.verdict = diagnosis.verdict,
          .leader_arm = diagnosis.leader,
          .leader_probability = diagnosis.best_probability[diagnosis.leader]};
}

std::vector<ArmBelief> FromDecision(std::span<const decision::BetaPosterior> posteriors,
                                    std::span<const ArmStanding> standings,
                                    const decision::Diagnosis& diagnosis,
                                    std::span<const std::string> arms) {
  std::vector<ArmBelief> beliefs;
  beliefs.reserve(posteriors.size());
  for (size_t arm = 0; arm < posteriors.size(); ++arm) {
    ArmBelief& belief =
        beliefs.emplace_back(ArmBelief{arms[arm], posteriors[arm].alpha, posteriors[arm].beta});
    if (!diagnosis.best_probability.empty()) belief.standing = standings[arm];
  }
  return beliefs;
}

DecisionEvent FromDecision(const decision::Decision& decision, std::span<const std::string> arms) {
  const decision::DecisionRecord& record = decision.record;
  DecisionEvent event;
  event.decision_id = record.decision_id;
  event.time_ns = static_cast<uint64_t>(record.time_ns);
  event.active_arm = record.active_arm;
  event.candidate_arm = record.candidate;
  event.outcome = record.outcome;
  event.command = decision.command;
  event.reward = record.reward;
  event.beliefs = FromDecision(record.posteriors, record.standings, record.diagnosis, arms);
  event.best_probability = record.diagnosis.best_probability;
  event.expected_loss_ratio = record.diagnosis.expected_loss_ratio;
  event.verdict = FromDecision(record.diagnosis);
  return event;
}

}  // namespace

class EmbeddedDecider::Impl final : public decision::AuditSink {
 public:
  Impl(decision::SessionSetup setup, decision::PolicyRegistry policies, EvidenceLedger given,
       const EmbeddedOptions& options)
      : session(std::move(setup), policies),
        ledger(std::move(given)),
        on_decision(options.on_decision),
        on_audit_row(options.on_audit_row) {}

  // Stores the decision's evidence, publishes the decision, and keeps its command for the game. A
  // new command replaces an older one that the game has not fetched.
  void Follow(const decision::Decision& decision) {
    ledger.Add(decision);
    last_decision = FromDecision(decision, session.arms());
    if (on_decision) on_decision(*last_decision);
    if (decision.command) pending_command = decision.command;
  }

  void OnAuditRow(const decision::AuditRow& row) override {
    on_audit_row(decision::AuditLines(row));
  }

  decision::DecisionSession session;
  EvidenceLedger ledger;
  const std::function<void(const DecisionEvent&)> on_decision;
  const std::function<void(std::string_view)> on_audit_row;  // null: no log
  uint32_t latest_epoch = 0;                                 // highest epoch of frames and outcomes
  std::optional<SwitchCommand> pending_command;
  std::optional<DecisionEvent> last_decision;
};

Result<std::unique_ptr<EmbeddedDecider>> EmbeddedDecider::Create(
    const EmbeddedOptions& options, std::span<const std::string> arms,
    std::span<const uint32_t> arm_versions, uint64_t now_ns) {
  const FloatEnvironmentScope environment;
  return StudyMaker{decision::ShippedPolicies()}.MakeDecider(options, arms, arm_versions, now_ns);
}

Result<std::unique_ptr<EmbeddedDecider>> StudyMaker::MakeDecider(
    const EmbeddedOptions& options, std::span<const std::string> arms,
    std::span<const uint32_t> arm_versions, uint64_t now_ns) const {
  Status status = ValidateEmbedded(options, arms.size(), arm_versions.size());
  if (!status.ok()) return status;
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
  setup.regime_priors = ledger.prior().regimes;
  if (const std::optional<std::string> error = decision::Validate(setup, policies)) {
    return Status(StatusCode::kInvalidArgument, *error);
  }
  auto impl = std::make_unique<EmbeddedDecider::Impl>(std::move(setup), policies, std::move(ledger),
                                                      options);
  if (options.on_audit_row)
    decision::StartAudit(impl->session, *impl, OriginOf(options, arm_versions));
  return std::unique_ptr<EmbeddedDecider>(new EmbeddedDecider(std::move(impl)));
}

Result<std::string> EmbeddedDecider::ArmOfPriors(const EmbeddedOptions& options,
                                                 std::span<const std::string> arms,
                                                 std::span<const uint32_t> arm_versions) {
  const FloatEnvironmentScope environment;
  const auto decider = Create(options, arms, arm_versions, 0);
  if (!decider.ok()) return decider.status();
  std::optional<size_t> best;
  const auto& given = (*decider)->impl_->ledger.prior().evidence;
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
  const FloatEnvironmentScope environment;
  decision::DecisionSession& session = impl_->session;
  size_t first = 0;  // index of the first frame that is not yet observed
  for (size_t i = 0; i < frames.size(); ++i) {
    impl_->latest_epoch = frames[i].switch_epoch;
    if ((frames[i].flags & kFrameBailOut) == 0) continue;
    session.ObserveFrames(frames.subspan(first, i + 1 - first));
    first = i + 1;
    impl_->Follow(session.ObserveBailOut(frames[i], static_cast<int64_t>(now_ns)));
  }
  session.ObserveFrames(frames.subspan(first));
}

// An outcome arrives after the arm has settled, long after the first frame of its epoch. It adds
// the reason and cost of the switch. An outcome is ignored if a later epoch has begun since,
// because it would take the session back to the earlier epoch.
void EmbeddedDecider::Observe(const SwitchOutcome& outcome, uint64_t now_ns) {
  const FloatEnvironmentScope environment;
  decision::DecisionSession& session = impl_->session;
  if (outcome.executed == 0) return session.ObserveRefusal(outcome.command_id);
  if (decision::IsLaterEpoch(impl_->latest_epoch, outcome.switch_epoch)) return;
  if (std::max(outcome.arm, outcome.trial_arm) >= session.arms().size()) return;
  impl_->latest_epoch = outcome.switch_epoch;
  session.ObserveSwitch(outcome.arm, outcome.switch_epoch, outcome.reason,
                        static_cast<int64_t>(now_ns), decision::SwitchCostOf(outcome));
}

void EmbeddedDecider::Observe(std::span<const ShadowSample> samples) {
  const FloatEnvironmentScope environment;
  impl_->session.ObserveShadow(samples);
}

void EmbeddedDecider::Observe(const SceneDescriptor& descriptor) {
  const FloatEnvironmentScope environment;
  impl_->session.ObserveDescriptor(descriptor);
}

void EmbeddedDecider::SetMode(Mode mode, uint32_t active_arm, uint64_t now_ns) {
  const FloatEnvironmentScope environment;
  if (active_arm >= impl_->session.arms().size()) return;
  impl_->session.SetMode(mode, active_arm, static_cast<int64_t>(now_ns));
  if (mode == Mode::kManual) impl_->pending_command.reset();
}

std::optional<SwitchCommand> EmbeddedDecider::Poll(uint64_t now_ns) {
  const FloatEnvironmentScope environment;
  const auto now = static_cast<int64_t>(now_ns);
  if (now >= impl_->session.next_tick_ns()) impl_->Follow(impl_->session.Tick(now));
  return std::exchange(impl_->pending_command, std::nullopt);
}

std::string EmbeddedDecider::AuditHeader() { return decision::AuditHeader(); }
uint64_t EmbeddedDecider::settling_ns() const {
  return static_cast<uint64_t>(impl_->session.setup().options.settling_ns);
}
bool EmbeddedDecider::uses_shadow() const { return impl_->session.policy_kind().uses_shadow; }
std::vector<ArmBelief> EmbeddedDecider::beliefs() const {
  const FloatEnvironmentScope environment;
  const decision::DecisionSession& session = impl_->session;
  return FromDecision(session.posteriors(), session.standings(), session.diagnosis(),
                      session.arms());
}
SceneVerdict EmbeddedDecider::verdict() const {
  const FloatEnvironmentScope environment;
  return FromDecision(impl_->session.diagnosis());
}
std::optional<double> EmbeddedDecider::saved_us() const {
  const FloatEnvironmentScope environment;
  return impl_->session.saved_us();
}
const std::optional<DecisionEvent>& EmbeddedDecider::last_decision() const {
  return impl_->last_decision;
}
uint64_t EmbeddedDecider::decision_count() const { return impl_->session.decision_count(); }
uint64_t EmbeddedDecider::prior_source_count() const { return impl_->ledger.prior().source_count; }
std::string EmbeddedDecider::ExportPriors() const {
  const FloatEnvironmentScope environment;
  return FormatPriors(impl_->ledger.records());
}

}  // namespace sweepstake
