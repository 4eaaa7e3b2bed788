#include "server/rpc/common/proto_conversion.h"

#include <grpcpp/support/proto_buffer_reader.h>
#include <grpcpp/support/proto_buffer_writer.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <variant>

#include "engine_client/decider/policy/scene_diagnosis.h"
#include "engine_client/decider/session/policy_registry.h"
#include "server/history/history_point.h"
#include "server/sessions/resume_token.h"

namespace sweepstake::rpc {
namespace {

// Masks of the flags that this version has, for frames and for shadow samples. Bits of later
// protocol versions are dropped.
constexpr uint32_t kKnownFlags = 63;
constexpr uint32_t kKnownShadowFlags = 3;

uint32_t Milliseconds(int64_t interval_ns) {
  return static_cast<uint32_t>(
      std::clamp<int64_t>((interval_ns + kNsPerMs / 2) / kNsPerMs, 0, UINT32_MAX));
}

void Fill(const sessions::FrameHistograms& frames, v1::FrameMeasurements& message) {
  history::ToProto(frames.frame_time_ns, *message.mutable_frame_time_ns());
  history::ToProto(frames.detection_time_ns, *message.mutable_detection_time_ns());
  history::ToProto(frames.native_bytes, *message.mutable_native_bytes());
}

}  // namespace

bool Parse(grpc::ByteBuffer& bytes, google::protobuf::Message& message) {
  bool parsed = false;
  {
    grpc::ProtoBufferReader reader(&bytes);
    parsed =
        reader.status().ok() && message.ParseFromZeroCopyStream(&reader) && reader.status().ok();
  }
  bytes.Clear();
  return parsed;
}

grpc::ByteBuffer Serialize(const google::protobuf::Message& message) {
  grpc::ByteBuffer bytes;
  grpc::ProtoBufferWriter writer(&bytes, grpc::kProtoBufferWriterMaxBufferLength,
                                 static_cast<int>(message.ByteSizeLong()));
  message.SerializeToZeroCopyStream(&writer);
  return bytes;
}

void ToProto(const SwitchCommand& command, v1::SwitchCommand& message) {
  message.set_command_id(command.command_id);
  message.set_arm(command.arm);
  message.set_reason(static_cast<v1::SwitchReason>(command.reason));
  message.set_trial_limit_percent(command.trial_limit_percent);
}

void ToProto(const decision::OrderReport& order, v1::OperatorOrder& message) {
  message.set_mode(static_cast<v1::Mode>(order.mode));
  if (order.arm) message.set_arm(*order.arm);
}

void ToProto(const decision::BetaPosterior& posterior, v1::BetaPosterior& message) {
  message.set_alpha(posterior.alpha);
  message.set_beta(posterior.beta);
}

void ToProto(const decision::DecisionRecord& record, v1::PosteriorSnapshot& message) {
  for (const auto& posterior : record.posteriors) ToProto(posterior, *message.add_arms());
  const decision::Diagnosis& diagnosis = record.diagnosis;
  if (diagnosis.best_probability.empty()) return;
  for (const ArmStanding& standing : record.standings) *message.add_standings() = ToProto(standing);
  message.set_verdict(static_cast<v1::Verdict>(diagnosis.verdict));
  message.set_leader_arm(diagnosis.leader);
  message.set_leader_probability(diagnosis.best_probability[diagnosis.leader]);
  if (record.saved_us) message.set_saved_us(*record.saved_us);
}

void ToProto(const priors::SceneKey& key, v1::ScenePosterior& message) {
  message.set_project(key.project);
  message.set_scene(key.scene);
  message.set_machine_class(key.machine_class);
  message.set_reward_version(key.reward_version);
}

namespace {

void Fill(const decision::BetaPosterior& posterior, bool with_intervals,
          v1::RewardPosterior& message) {
  message.set_alpha(posterior.alpha);
  message.set_beta(posterior.beta);
  if (!with_intervals) return;
  const decision::CredibleInterval of_95 = decision::CentralInterval(posterior, 0.95);
  const decision::CredibleInterval of_50 = decision::CentralInterval(posterior, 0.5);
  message.set_low_95(of_95.low);
  message.set_low_50(of_50.low);
  message.set_high_50(of_50.high);
  message.set_high_95(of_95.high);
}

void SetDiagnosis(std::span<const decision::SceneArm> arms, v1::ScenePosterior& message) {
  const decision::SceneDiagnosis scene = decision::DiagnoseScene(arms, message.reward_version());
  message.set_verdict(static_cast<v1::Verdict>(scene.verdict));
  message.set_expected_loss_ratio(scene.expected_loss_ratio);
  message.set_value_remaining_ratio(scene.value_remaining_ratio);
  if (scene.leader) message.set_leader_arm(std::string(arms[*scene.leader].name));
  for (size_t i = 0; i < arms.size(); ++i) {
    const decision::ArmDiagnosis& arm = scene.arms[i];
    v1::ArmPosterior& filled = *message.mutable_arms(static_cast<int>(i));
    filled.set_is_outdated(arm.is_outdated);
    if (arm.best_probability) filled.set_best_probability(*arm.best_probability);
    if (arm.cost_ratio) ToProto(*arm.cost_ratio, *filled.mutable_cost_ratio());
  }
}

}  // namespace

namespace {

// Returns the arm with the lowest mean cost in each regime with evidence of several arms, each
// once.
std::set<std::string> RegimeArms(const priors::SceneEvidence& scene) {
  std::map<std::string_view, std::vector<decision::VersionEvidence>> regimes;
  for (const priors::SceneEvidence::Arm& arm : scene.arms) {
    for (const auto& [regime, measured] : arm.regimes) {
      if (!regime.empty())
        regimes[regime].push_back({arm.name, arm.backend_version, priors::EvidenceOf(measured)});
    }
  }
  std::set<std::string> best_arms;
  for (const auto& [regime, versions] : regimes) {
    const decision::PooledScene pooled = decision::PoolScene(versions);
    const decision::SceneArm* best = nullptr;
    size_t count = 0;
    for (const decision::SceneArm& arm : pooled.arms) {
      if (decision::IsOutdated(arm, pooled.arms)) continue;
      ++count;
      if (best == nullptr || arm.posterior.mean() > best->posterior.mean()) best = &arm;
    }
    if (count > 1) best_arms.emplace(best->name);
  }
  return best_arms;
}

}  // namespace

void ToProto(const priors::SceneEvidence& scene, v1::ScenePosterior& message) {
  ToProto(scene.key, message);
  message.set_source_count(scene.source_count);
  const decision::PooledScene pooled = priors::Pool(scene.arms);
  for (size_t i = 0; i < scene.arms.size(); ++i) {
    const priors::SceneEvidence::Arm& arm = scene.arms[i];
    v1::ArmPosterior& filled = *message.add_arms();
    filled.set_arm(arm.name);
    filled.set_backend_version(arm.backend_version);
    Fill(pooled.arms[i].posterior, /*with_intervals=*/true, *filled.mutable_posterior());
    filled.set_window_count(arm.live.window_count);
    filled.set_visit_count(arm.lane.window_count);
    filled.set_bail_out_count(arm.live.bail_out_count);
    filled.set_unix_last_seen_s(static_cast<int64_t>(arm.last_seen_unix_s));
    if (pooled.window_evidence > 0)
      filled.set_effective_window_count(pooled.pooled[i].evidence() / pooled.window_evidence);
  }
  SetDiagnosis(pooled.arms, message);
  for (const std::string& arm : RegimeArms(scene)) message.add_regime_arms(arm);
}

absl::StatusOr<std::vector<v1::ScenePosterior>> ToProto(
    const absl::StatusOr<std::vector<priors::SceneEvidence>>& page) {
  if (!page.ok()) return page.status();
  std::vector<v1::ScenePosterior> messages(page->size());
  for (size_t i = 0; i < page->size(); ++i) ToProto((*page)[i], messages[i]);
  return messages;
}

namespace {

template <typename Set>
void SetIfPresent(const std::optional<double>& value, Set set) {
  if (value) set(static_cast<float>(*value));
}

void Fill(const decision::ArmReport& arm, v1::RegimeArm& message) {
  message.set_best_probability(static_cast<float>(arm.best_probability));
  if (!arm.cost) return;
  message.set_cost_us(static_cast<float>(arm.cost->us));
  message.set_low_us(static_cast<float>(arm.cost->low_us));
  message.set_high_us(static_cast<float>(arm.cost->high_us));
}

void Fill(const decision::RegimeReport& regime, std::span<const std::string> arms,
          v1::RegimePosterior& message) {
  const decision::RegimeCentre& centre = regime.centre;
  SetIfPresent(centre.object_count, [&](float value) { message.set_object_count(value); });
  SetIfPresent(centre.speed_mean, [&](float value) { message.set_speed_mean(value); });
  SetIfPresent(centre.static_ratio, [&](float value) { message.set_static_ratio(value); });
  message.set_is_present(regime.is_present);
  message.set_frame_share(static_cast<float>(regime.frame_share));
  for (const decision::ArmReport& arm : regime.arms) Fill(arm, *message.add_arms());
  if (regime.best_arm) message.set_best_arm(arms[*regime.best_arm]);
  SetIfPresent(regime.ran_us, [&](float value) { message.set_ran_us(value); });
  SetIfPresent(regime.saved_against_single_us,
               [&](float value) { message.set_saved_against_single_us(value); });
  SetIfPresent(regime.saved_against_reference_us,
               [&](float value) { message.set_saved_against_reference_us(value); });
  SetIfPresent(regime.saved_against_initial_us,
               [&](float value) { message.set_saved_against_initial_us(value); });
}

}  // namespace

void ToProto(const sessions::SceneActivity& activity, v1::ScenePosterior& message) {
  const sessions::SceneRun& run = activity.run;
  message.set_active_session_count(run.session_count);
  if (run.session_count == 0) return;
  v1::SceneActivity& filled = *message.mutable_activity();
  filled.set_session_id(run.session_id);
  filled.set_active_arm(run.active_arm);
  filled.set_initial_arm(activity.arms[activity.initial_arm]);
  filled.set_unix_active_since_ms(activity.unix_active_since_ms);
  filled.set_recent_switch_count(activity.recent_switch_count);
  filled.set_is_changing(activity.is_changing);
  filled.mutable_arms()->Add(activity.arms.begin(), activity.arms.end());
  Fill(activity.report.total, activity.arms, *filled.mutable_total());
  for (const decision::RegimeReport& regime : activity.report.regimes)
    Fill(regime, activity.arms, *filled.add_regimes());
}

void ToProto(const sessions::SessionDecision& event, v1::DecisionEvent& message) {
  const sessions::SessionIdentity& identity = event.session;
  const decision::DecisionRecord& record = event.record;
  message.set_unix_ms(event.unix_ms);
  if (event.measurements != nullptr) Fill(*event.measurements, *message.mutable_measurements());
  message.set_session_id(identity.id);
  message.set_project(identity.scene.project);
  message.set_scene(identity.scene.scene);
  message.set_machine_class(identity.scene.machine_class);
  message.set_policy(identity.policy);
  message.set_reward_version(identity.scene.reward_version);
  message.set_decision_id(record.decision_id);
  message.set_active_arm(identity.arms[record.active_arm]);
  if (record.candidate) message.set_candidate_arm(identity.arms[*record.candidate]);
  message.set_outcome(static_cast<v1::DecisionOutcome>(record.outcome));
  if (record.reason) message.set_reason(static_cast<v1::SwitchReason>(*record.reason));
  if (record.reward) message.set_reward(*record.reward);
  const decision::Diagnosis& diagnosis = record.diagnosis;
  message.mutable_best_probability()->Assign(diagnosis.best_probability.begin(),
                                             diagnosis.best_probability.end());
  message.set_expected_loss_ratio(diagnosis.expected_loss_ratio);
  message.set_verdict(static_cast<v1::Verdict>(diagnosis.verdict));
  if (diagnosis.best_probability.empty()) return;
  message.mutable_arms()->Add(identity.arms.begin(), identity.arms.end());
  for (const ArmStanding& standing : record.standings) *message.add_standings() = ToProto(standing);
}

void ToProto(const sessions::GameSession& session, const sessions::SessionRequest& hello,
             const RpcOptions& options, v1::Welcome& message) {
  const sessions::SessionIdentity& identity = session.identity();
  const decision::DecisionOptions& decision = session.decisions().setup().options;
  if (hello.takes_orders) message.add_capabilities(v1::CAPABILITY_OPERATOR_ORDERS);
  if (hello.shows_boxes) message.add_capabilities(v1::CAPABILITY_BOX_VIEW);
  if (hello.stops_trials) message.add_capabilities(v1::CAPABILITY_STOPS_TRIALS);
  message.set_session_id(identity.id);
  message.set_resume_token(
      sessions::ResumeTokenOf(identity.id, identity.origin.token_id, options.resume_secret));
  message.set_acknowledged_sequence(session.durable_sequence());
  message.set_max_batch_frames(kMaxBatchFrames);
  message.set_max_message_bytes(kMaxMessageBytes);
  message.set_decision_interval_ms(std::max(1u, Milliseconds(decision.decision_interval_ns)));
  message.set_settling_ms(Milliseconds(decision.settling_ns));
  message.set_bail_out_ms(Milliseconds(decision.bail_out_ns));
  message.set_daemon_version(options.daemon_version);
  message.set_policy(identity.policy);
  message.set_cooldown_ms(Milliseconds(decision.cooldown_ns));
  *message.mutable_weights() = ToProto(decision.weights);
  message.set_seed(identity.seed);
  message.set_prior_source_count(session.prior_source_count().value_or(0));
  message.set_priors_unavailable(!session.prior_source_count());
  for (const auto& posterior : session.decisions().posteriors())
    ToProto(posterior, *message.add_priors());
}

void ToProto(const sessions::SessionView& session, v1::SessionInfo& message) {
  message.set_session_id(session.id);
  message.set_project(session.scene.project);
  message.set_scene(session.scene.scene);
  message.set_build(session.client.build);
  message.set_client_address(session.client.address);
  message.set_state(static_cast<v1::SessionState>(session.state));
  message.set_active_arm(session.active_arm);
  message.set_mode(static_cast<v1::Mode>(session.mode));
  message.set_unix_start_ms(session.unix_start_ms);
  if (session.unix_last_message_ms) message.set_unix_last_message_ms(*session.unix_last_message_ms);
  message.set_dropped_frame_count(session.dropped_frame_count);
  message.set_machine_class(session.scene.machine_class);
  message.set_initial_arm(session.initial_arm);
  message.set_takes_orders(session.takes_orders);
  message.set_shows_boxes(session.shows_boxes);
}

void ToProto(const alerts::Alert& alert, v1::Alert& message) {
  const alerts::Finding& finding = alert.finding;
  message.set_id(alert.id);
  message.set_rule(std::string(alerts::NameOf(alert.key.rule)));
  message.set_severity(static_cast<v1::AlertSeverity>(finding.severity));
  const priors::SceneKey& scene = alert.key.scene;
  if (!scene.project.empty()) {
    message.set_project(scene.project);
    message.set_scene(scene.scene);
    message.set_machine_class(scene.machine_class);
    message.set_reward_version(scene.reward_version);
  }
  message.set_text(finding.text);
  message.set_session_count(finding.session_count);
  for (const std::string& id : finding.session_ids) message.add_session_ids(id);
  message.set_unix_since_ms(alert.unix_since_ms);
  if (finding.loss_us) message.set_loss_us(*finding.loss_us);
  if (!alert.silence) return;
  v1::AlertSilence& silence = *message.mutable_silence();
  silence.set_unix_until_ms(alert.silence->unix_until_ms);
  silence.set_comment(alert.silence->comment);
  silence.set_silenced_by(alert.silence->silenced_by);
}

void ToProto(const events::EventStamp& stamp, v1::EventStamp& message) {
  message.set_boot(stamp.boot);
  message.set_sequence(stamp.sequence);
  message.set_unix_ms(stamp.unix_ms);
}

namespace {

// Fills in Beta(1,1) plus the sum.
void Fill(const decision::EvidenceSum& sum, bool with_intervals, v1::RewardPosterior& message) {
  Fill(decision::BetaPosterior{1 + sum.alpha, 1 + sum.beta}, with_intervals, message);
}

void Fill(const decision::PriorsArm& arm, bool with_intervals, v1::ArmEvidence& message) {
  const decision::EvidenceSum& live = arm.evidence.live;
  const decision::EvidenceSum& lane = arm.evidence.lane;
  Fill(arm.pooled, with_intervals, *message.mutable_posterior());
  if (live.evidence() > 0) Fill(live, with_intervals, *message.mutable_live());
  if (lane.evidence() > 0) Fill(lane, with_intervals, *message.mutable_lane());
  if (arm.cost_ratio) ToProto(*arm.cost_ratio, *message.mutable_cost_ratio());
}

}  // namespace

void ToProto(const decision::SceneComparison& scene, bool with_intervals,
             v1::SceneComparison& message) {
  message.set_project(scene.key.project);
  message.set_scene(scene.key.scene);
  message.set_machine_class(scene.key.machine_class);
  message.set_reward_version(scene.key.reward_version);
  message.set_regime(scene.key.regime);
  message.set_known_in_both(scene.in_both());
  message.set_leader_changed(scene.leader_changed());
  for (const decision::ArmComparison& arm : scene.arms) {
    v1::ArmComparison& filled = *message.add_arms();
    filled.set_arm(arm.arm);
    if (arm.before) Fill(*arm.before, with_intervals, *filled.mutable_before());
    if (arm.after) Fill(*arm.after, with_intervals, *filled.mutable_after());
    filled.set_changed(arm.changed());
    message.set_largest_log_change(
        std::max(message.largest_log_change(), std::abs(arm.log_change())));
  }
}

void ToProto(const priors::AuditSegment& segment, v1::AuditSegment& message) {
  message.set_session_id(segment.session_id);
  message.set_segment(segment.segment);
  message.set_project(segment.project);
  message.set_scene(segment.scene);
  message.set_unix_start_ms(segment.unix_start_ms);
  message.set_row_count(segment.row_count);
  message.set_first_row(segment.first_row);
  message.set_lost_row_count(segment.lost_row_count);
  message.set_token_id(segment.token_id);
  message.set_party(segment.party);
}

Mode FromProto(v1::Mode mode) { return static_cast<Mode>(mode); }

namespace {

bool Has(const v1::Hello& hello, v1::Capability capability) {
  const auto& named = hello.capabilities();
  return std::find(named.begin(), named.end(), capability) != named.end();
}

FrameSample FrameOf(const v1::FrameBatch& batch, int i) {
  return {.frame_index = batch.first_frame_index() + static_cast<uint64_t>(i),
          .frame_time_ns = batch.frame_time_ns(i),
          .detection_time_ns = batch.detection_time_ns(i),
          .aabb_check_count = batch.aabb_check_count(i),
          .native_bytes = batch.native_bytes(i),
          .object_count = batch.object_count(i),
          .arm = batch.arm(i),
          .switch_epoch = batch.switch_epoch(i),
          .flags = batch.flags(i) & kKnownFlags};
}

FrameSample FrameOf(const v1::BailOut& bail_out) {
  FrameSample frame;
  frame.frame_index = bail_out.frame_index();
  frame.frame_time_ns = bail_out.frame_time_ns();
  frame.detection_time_ns = bail_out.detection_time_ns();
  frame.arm = bail_out.arm();
  frame.switch_epoch = bail_out.switch_epoch();
  frame.flags = bail_out.flags() & kKnownFlags;
  return frame;
}

ShadowSample Read(const v1::ShadowSample& sample) {
  return {.first_frame_index = sample.first_frame_index(),
          .detection_time_ns = sample.detection_time_ns(),
          .build_time_ns = sample.build_time_ns(),
          .aabb_check_count = sample.aabb_check_count(),
          .native_bytes = sample.native_bytes(),
          .arm = sample.arm(),
          .object_count = sample.object_count(),
          .frame_count = sample.frame_count(),
          .flags = sample.flags() & kKnownShadowFlags};
}

decision::SwitchCost CostOf(const v1::SwitchOutcome& outcome) {
  decision::SwitchCost cost = {
      .rebuild_time_ns = std::min<uint64_t>(outcome.rebuild_time_ns(), sessions::kMaxFrameNs),
      .settling_cost_ns = std::min<uint64_t>(outcome.settling_cost_ns(), sessions::kMaxFrameNs)};
  if (outcome.trial_detection_time_ns() > 0) {
    cost.ended_trial = {.arm = outcome.trial_arm(),
                        .detection_time_ns = std::min<uint64_t>(outcome.trial_detection_time_ns(),
                                                                sessions::kMaxFrameNs)};
  }
  return cost;
}

// Reuses the memory of `batch`.
void Read(const v1::FrameBatch& message, protocol::FrameBatch& batch) {
  batch.frames.clear();
  for (int i = 0; i < message.frame_time_ns_size(); ++i)
    batch.frames.push_back(FrameOf(message, i));
  batch.shadow_samples.clear();
  for (const v1::ShadowSample& sample : message.shadow_samples())
    batch.shadow_samples.push_back(Read(sample));
  batch.dropped_frame_count = message.dropped_frame_count();
  batch.invalid_box_count = message.invalid_box_count();
  batch.scene_descriptor.reset();
  if (message.has_scene_descriptor())
    batch.scene_descriptor = sweepstake::FromProto(message.scene_descriptor());
}

sessions::SwitchAnswer Read(const v1::SwitchOutcome& message) {
  return {.command_id = message.command_id(),
          .executed = message.executed(),
          .arm = message.arm(),
          .switch_epoch = message.switch_epoch(),
          .reason = static_cast<SwitchReason>(message.reason()),
          .cost = CostOf(message)};
}

// Returns whether the message has an enum value of a newer protocol.
bool HasUnknownValue(const v1::StreamTelemetryRequest& request) {
  if (request.has_switch_outcome())
    return !v1::SwitchReason_IsValid(request.switch_outcome().reason());
  return request.has_mode_change() && !v1::Mode_IsValid(request.mode_change().mode());
}

}  // namespace

v1::RewardWeights ToProto(const RewardWeights& weights) {
  v1::RewardWeights message;
  message.set_fps(weights.fps);
  message.set_detection(weights.detection);
  message.set_memory(weights.memory);
  message.set_checks(weights.checks);
  return message;
}

DecisionRules RulesOf(const v1::Hello& message) {
  DecisionRules rules;
  if (message.has_weights()) {
    const v1::RewardWeights& weights = message.weights();
    rules.weights = {.fps = weights.fps(),
                     .detection = weights.detection(),
                     .memory = weights.memory(),
                     .checks = weights.checks()};
  }
  if (message.has_decision_interval_ns())
    rules.decision_interval_ns = message.decision_interval_ns();
  if (message.has_cooldown_ns()) rules.cooldown_ns = message.cooldown_ns();
  if (message.has_settling_ns()) rules.settling_ns = message.settling_ns();
  return rules;
}

sessions::SessionRequest FromProto(const v1::Hello& message) {
  const DecisionRules rules = RulesOf(message);
  const decision::PolicyKind& policy =
      decision::PolicyKindOf(message.policy(), decision::ShippedPolicies());
  sessions::SessionRequest hello{
      .scene = {message.project(), message.scene(), message.machine_class(),
                decision::RewardVersionOf(policy, rules.weights.value_or(RewardWeights()))},
      .arms = {},
      .backend_versions = {},
      .origin = {.build = message.build()},
      .session_id = message.session_id(),
      .resume_token = message.resume_token(),
      .policy = message.policy(),
      .rules = rules,
      .mode = FromProto(message.mode()),
      .active_arm = message.active_arm(),
      .initial_arm = message.initial_arm(),
      .switch_epoch = message.switch_epoch(),
      .seed = message.seed(),
      .time_scale = std::max(1.0, message.time_scale()),
      .ignores_priors = message.ignore_priors(),
      .takes_orders = Has(message, v1::CAPABILITY_OPERATOR_ORDERS),
      .shows_boxes = Has(message, v1::CAPABILITY_BOX_VIEW),
      .stops_trials = Has(message, v1::CAPABILITY_STOPS_TRIALS)};
  for (const v1::Arm& arm : message.arms()) {
    hello.arms.push_back(arm.name());
    hello.backend_versions.push_back(arm.backend_version());
  }
  return hello;
}

void FromProto(const v1::StreamTelemetryRequest& request, sessions::Telemetry& telemetry) {
  telemetry.sequence = request.sequence();
  if (request.has_frame_batch()) {
    if (!std::holds_alternative<protocol::FrameBatch>(telemetry.message))
      telemetry.message.emplace<protocol::FrameBatch>();
    return Read(request.frame_batch(), std::get<protocol::FrameBatch>(telemetry.message));
  }
  if (HasUnknownValue(request)) {
    telemetry.message = sessions::UnknownMessage{};
  } else if (request.has_switch_outcome()) {
    telemetry.message = Read(request.switch_outcome());
  } else if (request.has_bail_out()) {
    telemetry.message = protocol::BailOut{FrameOf(request.bail_out())};
  } else if (request.has_mode_change()) {
    const v1::ModeChange& change = request.mode_change();
    telemetry.message =
        ModeChange{FromProto(change.mode()), change.active_arm(), change.order_id()};
  } else if (request.has_order_refusal()) {
    const v1::OrderRefusal& refusal = request.order_refusal();
    telemetry.message = protocol::OrderRefusal{
        .order_id = refusal.order_id(),
        .reason = static_cast<protocol::OrderRefusalReason>(refusal.reason())};
  } else {
    telemetry.message = sessions::UnknownMessage{};
  }
}

priors::SceneKey FromProto(const v1::ScenePosterior& message) {
  return {message.project(), message.scene(), message.machine_class(), message.reward_version()};
}

}  // namespace sweepstake::rpc
