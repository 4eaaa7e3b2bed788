// The frame path's plain structs as messages of sweepstake.v1.
#pragma once

#include <string>

#include "engine_client/telemetry/sample_queue.h"
#include "sweepstake/v1/telemetry.pb.h"

namespace sweepstake {

v1::SceneDescriptor ToWire(const SceneDescriptor& descriptor);
v1::ShadowSample ToWire(const ShadowSample& sample);
// A refused outcome gets an error text.
v1::StreamTelemetryRequest ToRequest(const SwitchOutcome& outcome);
v1::StreamTelemetryRequest ToRequest(const ModeNote& change);
v1::StreamTelemetryRequest BailOutRequest(const FrameSample& sample);
// Answers a command for an arm that this session does not have.
v1::StreamTelemetryRequest RefusalRequest(const v1::SwitchCommand& command, uint32_t active_arm,
                                          uint32_t switch_epoch);

}  // namespace sweepstake
