// Checks a client's message before any part of it is applied. Pure functions; the cost is linear in
// the size of the message.
//
// A message that breaks the contract (lengths, indices, names, absent fields) ends the stream with
// INVALID_ARGUMENT, or with FAILED_PRECONDITION if the order of messages or the protocol version is
// wrong. Messages and values of a newer protocol are allowed; the session counts them and does not
// apply them. The session also skips impossible measurements (server/sessions/common/rejection.h).
#pragma once

#include "absl/status/status.h"
#include "server/rpc/common/options.h"
#include "sweepstake/v1/priors.pb.h"
#include "sweepstake/v1/telemetry.pb.h"

namespace sweepstake::rpc {

// Checks a Hello against the daemon's options. REQUIRES: `hello` names a policy. If the client
// named none, the caller sets the daemon's default policy first.
absl::Status CheckHello(const v1::Hello& hello, const RpcOptions& options);

// Checks any request after Hello. REQUIRES: arm_count > 0.
absl::Status CheckRequest(const v1::StreamTelemetryRequest& request, uint32_t arm_count);

absl::Status CheckPriorRecord(const v1::PriorRecord& record);

}  // namespace sweepstake::rpc
