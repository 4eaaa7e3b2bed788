// Alone in its file: it is the only part of the session with a daemon that links the generated
// messages. Two libraries of one process must not both register those with protobuf, so the library
// of c_daemon.h must not contain them.
#include "engine_client/telemetry/daemon_channel.h"
#include "engine_client/telemetry/protocol/wire.h"

namespace sweepstake {

v1::ErrorReason ReasonOf(const grpc::Status& status) {
  v1::ErrorReason reason = v1::ERROR_REASON_UNSPECIFIED;
  if (const auto own = protocol::StatusIn(status.error_details()))
    v1::ErrorReason_Parse("ERROR_REASON_" + own->reason, &reason);
  return reason;
}

}  // namespace sweepstake
