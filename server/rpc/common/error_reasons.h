// Makes the statuses that refuse a call or end a stream: each has a reason that programs can act
// on. Pure functions, but for the counting.
#pragma once

#include <grpcpp/support/status.h>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "server/rpc/common/options.h"
#include "sweepstake/v1/errors.pb.h"

namespace sweepstake::rpc {

// Returns a status with the reason and its code. `message` says what to do next.
absl::Status Refused(v1::ErrorReason reason, absl::string_view message);
// Returns the reason of such a status; UNSPECIFIED if it has none.
v1::ErrorReason ReasonOfRefusal(const absl::Status& status);
// Returns an error of the store with a reason: its code, and with it what the client is to do,
// stays.
absl::Status StoreFailed(const absl::Status& status);

// Returns the status as it goes to the client, with its reason in a google.rpc.ErrorInfo, and
// counts that reason. A status without one counts as ERROR_REASON_UNSPECIFIED, unless it is OK or
// CANCELLED: the latter is for clients that have gone.
grpc::Status ToGrpc(const absl::Status& status, Counters& counters);

// Returns the name that the reason has in google.rpc.ErrorInfo.
absl::string_view NameOf(v1::ErrorReason reason);

}  // namespace sweepstake::rpc
