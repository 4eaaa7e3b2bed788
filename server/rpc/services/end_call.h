// How a function that answers one request ends the call.
#pragma once

#include <functional>

#include "absl/status/status.h"
#include "server/rpc/common/error_reasons.h"

namespace sweepstake::rpc {

// Ends the call. Called once, on any thread. The response must be complete before this call.
// Request and response live until the call has ended.
using EndCall = std::function<void(const absl::Status&)>;

// The status of a call whose job the store has refused, because its queue is full.
inline absl::Status StoreBusy() {
  return Refused(v1::ERROR_REASON_STORE_BUSY, "the prior store is overloaded; try again later");
}

}  // namespace sweepstake::rpc
