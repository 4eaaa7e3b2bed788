// Makes the statuses that refuse a call or end a stream. Each has a reason for programs to act on;
// server/sessions/common/reasons.h has the reasons of sessions. Pure functions, except for the
// counting.
#pragma once

#include <grpcpp/support/status.h>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "server/rpc/common/options.h"
#include "server/sessions/common/reasons.h"
#include "sweepstake/v1/errors.pb.h"

namespace sweepstake::rpc {

// Returns a status with the reason and its code. `message` must say what to do next.
absl::Status Refused(v1::ErrorReason reason, absl::string_view message);
// Returns the reason of such a status; UNSPECIFIED if it has none.
v1::ErrorReason ReasonOfRefusal(const absl::Status& status);
// Adds a reason to an error of the store. The code is kept, because it determines what the client
// can do.
absl::Status StoreFailed(const absl::Status& status);

// Counts the reason. A status without one counts as ERROR_REASON_UNSPECIFIED, unless it is OK or
// CANCELLED, the status of clients that have disconnected.
void CountError(const absl::Status& status, Counters& counters);
// Counts the reason, and returns the status for the client, with the reason in a
// google.rpc.ErrorInfo.
grpc::Status ToGrpc(const absl::Status& status, Counters& counters);

// Returns the reason's name in google.rpc.ErrorInfo.
absl::string_view NameOf(v1::ErrorReason reason);

}  // namespace sweepstake::rpc
