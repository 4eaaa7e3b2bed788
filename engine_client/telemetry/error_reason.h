// Reads from a status why the daemon refused a call or ended a stream (errors.proto). Pure
// functions.
#pragma once

#include <grpcpp/support/status.h>

#include <string>

#include "sweepstake/v1/errors.pb.h"

namespace sweepstake {

// Returns the reason; ERROR_REASON_UNSPECIFIED if the status contains none or one that only newer
// versions define.
v1::ErrorReason ReasonOf(const grpc::Status& status);

// Returns the message, with the reason's name in brackets if there is one: "... (DRAINING)".
std::string MessageWithReason(const grpc::Status& status);

}  // namespace sweepstake
