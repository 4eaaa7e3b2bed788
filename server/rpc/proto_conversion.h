// Between the server's values and the messages of sweepstake.v1. Pure.
#pragma once

#include <grpcpp/support/byte_buffer.h>
#include <grpcpp/support/status.h>

#include <span>
#include <string>

#include "absl/status/status.h"
#include "server/decision/types.h"
#include "server/priors/prior_store.h"
#include "sweepstake/v1/posteriors.pb.h"
#include "sweepstake/v1/priors.pb.h"
#include "sweepstake/v1/telemetry.pb.h"

namespace sweepstake::rpc {

// The codes have the same values.
grpc::Status ToGrpc(const absl::Status& status);

// False: the bytes are no such message. Reuses the memory of `message`; consumes the buffer.
bool Parse(grpc::ByteBuffer& bytes, google::protobuf::Message& message);
grpc::ByteBuffer Serialize(const google::protobuf::Message& message);

// Of the only context bucket.
priors::EvidenceKey EvidenceKeyOf(const priors::SceneKey& scene, const std::string& arm,
                                  uint32_t backend_version);

void FillPosterior(const decision::BetaPosterior& posterior, v1::BetaPosterior& message);
void FillSnapshot(std::span<const decision::BetaPosterior> posteriors,
                  const decision::Diagnosis& diagnosis, v1::PosteriorSnapshot& message);
// Beta(1,1) plus the evidence. active_session_count is the caller's.
void FillScene(const priors::SceneEvidence& scene, v1::ScenePosterior& message);
// All but the names of session, scene and policy.
void FillDecision(const decision::DecisionRecord& record, std::span<const std::string> arms,
                  v1::DecisionEvent& message);

void FillRecord(const priors::PriorRecord& record, v1::PriorRecord& message);
priors::PriorRecord RecordOf(const v1::PriorRecord& message);

}  // namespace sweepstake::rpc
