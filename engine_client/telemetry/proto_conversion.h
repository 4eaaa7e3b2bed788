// The only converter between the public plain structs and the messages of sweepstake.v1. ToProto
// makes a message, FromProto reads one. Pure functions.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine_client/telemetry/common/sample_queue.h"
#include "engine_client/telemetry/embedded/priors_file.h"
#include "sweepstake/embedded_decider.h"
#include "sweepstake/v1/priors.pb.h"
#include "sweepstake/v1/telemetry.pb.h"

namespace sweepstake {

v1::SceneDescriptor ToProto(const SceneDescriptor& descriptor);
SceneDescriptor FromProto(const v1::SceneDescriptor& message);

v1::ShadowSample ToProto(const ShadowSample& sample);
// Appends the sample to the batch's columns.
void ToProto(const FrameSample& sample, v1::FrameBatch& batch);

v1::StreamTelemetryRequest ToProto(const SwitchOutcome& outcome);
v1::StreamTelemetryRequest ToProto(const ModeChange& change);
// Makes the report of a frame over the bail-out limit.
v1::StreamTelemetryRequest BailOutToProto(const FrameSample& sample);
// Makes the answer to a command for an arm that this session does not have.
v1::StreamTelemetryRequest RefusalToProto(const v1::SwitchCommand& command, uint32_t active_arm,
                                          uint32_t switch_epoch);

v1::StreamTelemetryRequest RefusalToProto(const v1::OperatorOrder& order,
                                          v1::OrderRefusalReason reason);

// The result is absent if the reason is unknown, which a daemon of this protocol version never
// sends.
std::optional<SwitchCommand> FromProto(const v1::SwitchCommand& message);
// The result is absent if the mode or the arm is unknown.
std::optional<OperatorOrder> FromProto(const v1::OperatorOrder& message, size_t arm_count);
// The result is absent if the verdict is of a later protocol, or if a value is outside of its
// range.
std::optional<SceneVerdict> FromProto(const v1::PosteriorSnapshot& message, size_t arm_count);

v1::Mode ToProto(Mode mode);

// The result is absent if a parameter of the posterior is not finite or not above 0.
std::optional<ArmBelief> FromProto(const v1::BetaPosterior& posterior, const std::string& arm);
// The result is absent if the number of posteriors is not that of the arms, or if one of them is
// not valid.
std::optional<std::vector<ArmBelief>> FromProto(
    const google::protobuf::RepeatedPtrField<v1::BetaPosterior>& posteriors,
    std::span<const std::string> arms);

v1::PriorRecord ToProto(const PriorRecord& record);
PriorRecord FromProto(const v1::PriorRecord& message);

}  // namespace sweepstake
