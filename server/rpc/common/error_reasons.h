// Creates the statuses that refuse a call or end a stream. Each status has a reason
// (v1::ErrorReason), by which programs decide what to do. server/sessions/common/reasons.h has the
// reasons of sessions. Pure functions, except those that count.
#pragma once

#include <grpcpp/support/status.h>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "server/rpc/common/options.h"
#include "server/sessions/common/reasons.h"
#include "sweepstake/v1/errors.pb.h"

namespace sweepstake::rpc {

// Returns a status with the reason, and with the status code of that reason. `message` must say
// what to do next.
absl::Status Refused(v1::ErrorReason reason, absl::string_view message);
// Returns the reason of a status; ERROR_REASON_UNSPECIFIED if it has none.
v1::ErrorReason ReasonOfRefusal(const absl::Status& status);
// Adds a reason to an error of the store. The status code stays, because it shows whether trying
// again can help. CANCELLED becomes UNAVAILABLE: the store stops changes when the daemon drains.
absl::Status StoreFailed(const absl::Status& status);

// Counts the status by its reason in Counters::error_counts. A status without a reason counts as
// ERROR_REASON_UNSPECIFIED. OK and CANCELLED (a client that has disconnected) without a reason are
// not counted.
void CountError(const absl::Status& status, Counters& counters);
// Counts the status as CountError does. Returns the status for the client, with the reason in a
// google.rpc.ErrorInfo.
grpc::Status ToGrpc(const absl::Status& status, Counters& counters);

// Returns the reason's name in google.rpc.ErrorInfo, which lacks the prefix ERROR_REASON_.
absl::string_view NameOf(v1::ErrorReason reason);

}  // namespace sweepstake::rpc
