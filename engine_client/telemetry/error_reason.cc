#include "engine_client/telemetry/error_reason.h"

#include "engine_client/telemetry/protocol/wire.h"

namespace sweepstake {
v1::ErrorReason ReasonOf(const grpc::Status& status) {
  v1::ErrorReason reason = v1::ERROR_REASON_UNSPECIFIED;
  v1::ErrorReason_Parse("ERROR_REASON_" + protocol::ErrorReasonIn(status.error_details()), &reason);
  return reason;
}

std::string MessageWithReason(const grpc::Status& status) {
  const std::string name = protocol::ErrorReasonIn(status.error_details());
  return name.empty() ? status.error_message() : status.error_message() + " (" + name + ")";
}

}  // namespace sweepstake
