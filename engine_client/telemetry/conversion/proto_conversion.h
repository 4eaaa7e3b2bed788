// Converts between the library's structs and protobuf messages of sweepstake.v1. ToProto makes a
// message, FromProto reads one. The command line and the daemon use it. (A session encodes its
// messages without protobuf: telemetry/protocol/wire.h.) Pure functions.
#pragma once

#include <optional>
#include <string>

#include "engine_client/decider/pooling/prior_record.h"
#include "sweepstake/embedded_decider.h"
#include "sweepstake/frame_sample.h"
#include "sweepstake/v1/posteriors.pb.h"
#include "sweepstake/v1/priors.pb.h"
#include "sweepstake/v1/telemetry.pb.h"

namespace sweepstake {

v1::SceneDescriptor ToProto(const SceneDescriptor& descriptor);
SceneDescriptor FromProto(const v1::SceneDescriptor& message);

// Returns nullopt if a parameter of the posterior is not finite or not above 0. `arm` is the arm's
// name.
std::optional<ArmBelief> FromProto(const v1::BetaPosterior& posterior, const std::string& arm);
void ToProto(const CostRatio& ratio, v1::CostRatio& message);
v1::ArmStanding ToProto(const ArmStanding& standing);
ArmStanding FromProto(const v1::ArmStanding& standing);
v1::PriorRecord ToProto(const PriorRecord& record);
PriorRecord FromProto(const v1::PriorRecord& message);

// Returns whether no single arm is the best in the scene, as its connected sessions report or, if
// there are none, by its stored regimes. `leader_arm` and the verdict are then not the answer.
bool IsChanging(const v1::ScenePosterior& scene);

}  // namespace sweepstake
