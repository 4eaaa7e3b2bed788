// The only converter between the public plain structs and protobuf's messages of sweepstake.v1, for
// messages that the command line exchanges with a daemon and writes to files. (A session encodes
// its messages without protobuf: protocol/wire.h.) ToProto makes a message, FromProto reads one.
// Pure functions.
#pragma once

#include <optional>
#include <string>

#include "engine_client/decider/embedded/priors_file.h"
#include "sweepstake/embedded_decider.h"
#include "sweepstake/frame_sample.h"
#include "sweepstake/v1/priors.pb.h"
#include "sweepstake/v1/telemetry.pb.h"

namespace sweepstake {

v1::SceneDescriptor ToProto(const SceneDescriptor& descriptor);
SceneDescriptor FromProto(const v1::SceneDescriptor& message);

// Returns nullopt if a parameter of the posterior is not finite or not above 0.
std::optional<ArmBelief> FromProto(const v1::BetaPosterior& posterior, const std::string& arm);
ArmStanding FromProto(const v1::ArmStanding& standing);
v1::PriorRecord ToProto(const PriorRecord& record);
PriorRecord FromProto(const v1::PriorRecord& message);

}  // namespace sweepstake
