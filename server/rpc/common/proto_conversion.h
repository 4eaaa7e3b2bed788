// The only converter between the messages of sweepstake.v1 and the server's values. ToProto fills a
// message, FromProto reads one. Pure functions.
#pragma once

#include <grpcpp/support/byte_buffer.h>

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine_client/decider/pooling/priors_diff.h"
#include "engine_client/decider/pooling/scene_prior.h"
#include "engine_client/decider/session/decision_observer.h"
#include "engine_client/decider/types.h"
#include "engine_client/telemetry/conversion/proto_conversion.h"
#include "server/alerts/alert.h"
#include "server/events/event.h"
#include "server/rpc/common/options.h"
#include "server/sessions/client_messages.h"
#include "server/sessions/prior_store.h"
#include "server/sessions/session_observer.h"
#include "server/sessions/session_table.h"
#include "sweepstake/v1/alerts.pb.h"
#include "sweepstake/v1/audit.pb.h"
#include "sweepstake/v1/events.pb.h"
#include "sweepstake/v1/posteriors.pb.h"
#include "sweepstake/v1/priors.pb.h"
#include "sweepstake/v1/sessions.pb.h"
#include "sweepstake/v1/telemetry.pb.h"

namespace sweepstake::rpc {

// Returns false if the bytes are not a message of this type. Reuses the memory of `message` and
// consumes the buffer.
bool Parse(grpc::ByteBuffer& bytes, google::protobuf::Message& message);
grpc::ByteBuffer Serialize(const google::protobuf::Message& message);

void ToProto(const SwitchCommand& command, v1::SwitchCommand& message);
// The caller sets order_id.
void ToProto(const decision::OrderReport& order, v1::OperatorOrder& message);
void ToProto(const decision::BetaPosterior& posterior, v1::BetaPosterior& message);
void ToProto(const decision::DecisionRecord& record, v1::PosteriorSnapshot& message);
// Sets only the fields of the key.
void ToProto(const priors::SceneKey& key, v1::ScenePosterior& message);
// The posteriors are Beta(1,1) plus the pooled evidence. The next function sets the other fields.
// The conversion takes 0.6 to 6 ms (7 to 32 arms), most of it for the credible intervals. For many
// scenes, call it on the store's reading thread, not on the decision loop.
void ToProto(const priors::SceneEvidence& scene, v1::ScenePosterior& message);
absl::StatusOr<std::vector<v1::ScenePosterior>> ToProto(
    const absl::StatusOr<std::vector<priors::SceneEvidence>>& page);
// Sets only active_session_count and activity.
void ToProto(const sessions::SceneActivity& activity, v1::ScenePosterior& message);
void ToProto(const sessions::SessionDecision& event, v1::DecisionEvent& message);
// Sets the capabilities that the client announced in its Hello and that the daemon supports. The
// caller sets resumed, protocol_version and batch_interval_ms.
void ToProto(const sessions::GameSession& session, const sessions::SessionRequest& hello,
             const RpcOptions& options, v1::Welcome& message);
void ToProto(const sessions::SessionView& session, v1::SessionInfo& message);
void ToProto(const alerts::Alert& alert, v1::Alert& message);
void ToProto(const events::EventStamp& stamp, v1::EventStamp& message);
// The caller sets builds. The intervals take 0.1 ms for each posterior.
void ToProto(const decision::SceneComparison& scene, bool with_intervals,
             v1::SceneComparison& message);
void ToProto(const priors::AuditSegment& segment, v1::AuditSegment& message);

// REQUIRES for the next three functions: the message has passed the checks of message_validation.h.
Mode FromProto(v1::Mode mode);
// Sets the scene's reward version to that of the policy and its weights. REQUIRES: the Hello names
// a policy.
sessions::SessionRequest FromProto(const v1::Hello& message);
// Returns the rules that the Hello sets, unchecked.
DecisionRules RulesOf(const v1::Hello& message);
v1::RewardWeights ToProto(const RewardWeights& weights);
// Reuses the memory of `telemetry`. A value of a scene descriptor that is negative or not finite
// counts as not measured, and each cost of a switch is limited to kMaxFrameNs.
void FromProto(const v1::StreamTelemetryRequest& request, sessions::Telemetry& telemetry);
// Reads only the fields of the key.
priors::SceneKey FromProto(const v1::ScenePosterior& message);

}  // namespace sweepstake::rpc
