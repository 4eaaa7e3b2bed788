// The only converter between the messages of sweepstake.v1 and the server's values. ToProto fills a
// message, FromProto reads one. Pure functions.
#pragma once

#include <grpcpp/support/byte_buffer.h>

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine_client/decider/pooling/scene_prior.h"
#include "engine_client/decider/session/decision_observer.h"
#include "engine_client/decider/types.h"
#include "server/rpc/common/options.h"
#include "server/sessions/audit_rows.h"
#include "server/sessions/prior_store.h"
#include "server/sessions/session_identity.h"
#include "server/watch/log_histogram.h"
#include "server/watch/watch_hub.h"
#include "sweepstake/v1/audit.pb.h"
#include "sweepstake/v1/events.pb.h"
#include "sweepstake/v1/posteriors.pb.h"
#include "sweepstake/v1/priors.pb.h"
#include "sweepstake/v1/telemetry.pb.h"

namespace sweepstake::rpc {

// Returns false if the bytes are not a message of this type. Reuses the memory of `message` and
// consumes the buffer.
bool Parse(grpc::ByteBuffer& bytes, google::protobuf::Message& message);
grpc::ByteBuffer Serialize(const google::protobuf::Message& message);

// Returns the key of an arm's evidence.
priors::EvidenceKey EvidenceKeyOf(const priors::SceneKey& scene, const std::string& arm,
                                  uint32_t backend_version, std::string_view measured_by);

void ToProto(const SwitchCommand& command, v1::SwitchCommand& message);
// The caller sets order_id.
void ToProto(const decision::OrderReport& order, v1::OperatorOrder& message);
void ToProto(const decision::BetaPosterior& posterior, v1::BetaPosterior& message);
// REQUIRES: something is learnt.
void ToProto(const decision::DecisionRecord& record, uint32_t arm, v1::ArmStanding& message);
void ToProto(const decision::DecisionRecord& record, v1::PosteriorSnapshot& message);
// Fills in the key only.
void ToProto(const priors::SceneKey& key, v1::ScenePosterior& message);
decision::ArmEvidence EvidenceOf(const priors::SceneEvidence::Arm& arm);
// The posteriors are Beta(1,1) plus what that is. The caller sets active_session_count.
void ToProto(const priors::SceneEvidence& scene, v1::ScenePosterior& message);
// The caller sets unix_ms.
void ToProto(const decision::DecisionRecord& record, const SessionIdentity& identity,
             v1::DecisionEvent& message);
void ToProto(const watch::FrameHistograms& frames, v1::FrameMeasurements& message);
// The caller sets resumed, acknowledged_sequence and prior_source_count.
void ToProto(const SessionIdentity& identity, std::span<const decision::BetaPosterior> posteriors,
             const RpcOptions& options, v1::Welcome& message);
void ToProto(const watch::EventStamp& stamp, v1::EventStamp& message);
void ToProto(const priors::PriorRecord& record, v1::PriorRecord& message);
void ToProto(const priors::AuditSegment& segment, v1::AuditSegment& message);

// Returns whether the client named the capability.
bool Has(const v1::Hello& hello, v1::Capability capability);

// The messages below must have passed message_validation.h.
Mode FromProto(v1::Mode mode);
SwitchReason FromProto(v1::SwitchReason reason);
// Reads frame i of the batch.
FrameSample FrameFromProto(const v1::FrameBatch& batch, int i);
FrameSample FromProto(const v1::BailOut& bail_out);
ShadowSample FromProto(const v1::ShadowSample& sample);
// A value that is negative or not finite counts as not measured.
decision::SceneDescriptor FromProto(const v1::SceneDescriptor& descriptor);
// Each cost is limited to kMaxFrameNs.
decision::SwitchCost FromProto(const v1::SwitchOutcome& outcome);
// These two read the key only. The reward version is that of the policy, which Hello must name.
priors::SceneKey FromProto(const v1::Hello& message);
priors::SceneKey FromProto(const v1::ScenePosterior& message);
priors::PriorRecord FromProto(const v1::PriorRecord& message);

}  // namespace sweepstake::rpc
