#include "server/rpc/proto_conversion.h"

#include <grpcpp/support/proto_buffer_reader.h>
#include <grpcpp/support/proto_buffer_writer.h>

namespace sweepstake::rpc {

grpc::Status ToGrpc(const absl::Status& status) {
  return {static_cast<grpc::StatusCode>(status.code()), std::string(status.message())};
}

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

priors::EvidenceKey EvidenceKeyOf(const priors::SceneKey& scene, const std::string& arm,
                                  uint32_t backend_version) {
  return {.project = scene.project,
          .scene = scene.scene,
          .context_bucket = {},
          .arm = arm,
          .backend_version = backend_version,
          .machine_class = scene.machine_class,
          .reward_version = scene.reward_version};
}

void FillPosterior(const decision::BetaPosterior& posterior, v1::BetaPosterior& message) {
  message.set_alpha(posterior.alpha);
  message.set_beta(posterior.beta);
}

void FillSnapshot(std::span<const decision::BetaPosterior> posteriors,
                  const decision::Diagnosis& diagnosis, v1::PosteriorSnapshot& message) {
  for (const auto& posterior : posteriors) FillPosterior(posterior, *message.add_arms());
  if (diagnosis.best_probability.empty()) return;
  message.set_verdict(static_cast<v1::Verdict>(diagnosis.verdict));
  message.set_leader_arm(diagnosis.leader);
  message.set_leader_probability(diagnosis.best_probability[diagnosis.leader]);
}

void FillScene(const priors::SceneEvidence& scene, v1::ScenePosterior& message) {
  message.set_project(scene.key.project);
  message.set_scene(scene.key.scene);
  message.set_machine_class(scene.key.machine_class);
  message.set_reward_version(scene.key.reward_version);
  message.set_source_count(scene.source_count);
  for (const auto& arm : scene.arms) {
    v1::ArmPosterior& filled = *message.add_arms();
    filled.set_arm(arm.name);
    filled.set_backend_version(arm.backend_version);
    FillPosterior({1 + arm.evidence.alpha, 1 + arm.evidence.beta}, *filled.mutable_posterior());
    filled.set_window_count(arm.evidence.window_count);
    filled.set_bail_out_count(arm.evidence.bail_out_count);
  }
}

void FillDecision(const decision::DecisionRecord& record, std::span<const std::string> arms,
                  v1::DecisionEvent& message) {
  message.set_decision_id(record.decision_id);
  message.set_active_arm(arms[record.active_arm]);
  if (record.candidate) message.set_candidate_arm(arms[*record.candidate]);
  message.set_outcome(static_cast<v1::DecisionOutcome>(record.outcome));
  if (record.reason) message.set_reason(static_cast<v1::SwitchReason>(*record.reason));
  if (record.reward) message.set_reward(*record.reward);
  const decision::Diagnosis& diagnosis = record.diagnosis;
  message.mutable_best_probability()->Assign(diagnosis.best_probability.begin(),
                                             diagnosis.best_probability.end());
  message.set_expected_loss_ratio(diagnosis.expected_loss_ratio);
  message.set_verdict(static_cast<v1::Verdict>(diagnosis.verdict));
  message.set_context_bucket(record.context);
}

void FillRecord(const priors::PriorRecord& record, v1::PriorRecord& message) {
  message.set_project(record.key.project);
  message.set_scene(record.key.scene);
  message.set_context_bucket(record.key.context_bucket);
  message.set_arm(record.key.arm);
  message.set_backend_version(record.key.backend_version);
  message.set_machine_class(record.key.machine_class);
  message.set_reward_version(record.key.reward_version);
  message.set_source_id(record.source_id);
  message.set_source_sequence(record.source_sequence);
  message.set_alpha_increment(record.evidence.alpha);
  message.set_beta_increment(record.evidence.beta);
  message.set_window_count(record.evidence.window_count);
  message.set_bail_out_count(record.evidence.bail_out_count);
}

priors::PriorRecord RecordOf(const v1::PriorRecord& message) {
  return {.key = {.project = message.project(),
                  .scene = message.scene(),
                  .context_bucket = message.context_bucket(),
                  .arm = message.arm(),
                  .backend_version = message.backend_version(),
                  .machine_class = message.machine_class(),
                  .reward_version = message.reward_version()},
          .source_id = message.source_id(),
          .source_sequence = message.source_sequence(),
          .evidence = {.alpha = message.alpha_increment(),
                       .beta = message.beta_increment(),
                       .window_count = message.window_count(),
                       .bail_out_count = message.bail_out_count()}};
}

}  // namespace sweepstake::rpc
