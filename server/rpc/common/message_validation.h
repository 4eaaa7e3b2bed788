// Checks a client's message before anything of it is applied. Pure functions; the cost is linear in
// the size of the message.
//
// There are two kinds of errors. A message that breaks the contract (lengths, indices, names,
// absent fields) ends the stream with INVALID_ARGUMENT, or with FAILED_PRECONDITION if the order or
// the version is wrong. A single frame or shadow visit whose values cannot have been measured is
// skipped and counted; the rest of its batch is used. What only a newer protocol has is no error:
// it is counted and not applied.
#pragma once

#include <optional>

#include "absl/status/status.h"
#include "engine_client/decider/types.h"
#include "server/rpc/common/options.h"
#include "sweepstake/v1/priors.pb.h"
#include "sweepstake/v1/telemetry.pb.h"

namespace sweepstake::rpc {

// Checks a Hello against the daemon's options. REQUIRES: it names a policy; the caller has filled
// in the daemon's default if the client named none.
absl::Status CheckHello(const v1::Hello& hello, const RpcOptions& options);

// Checks any request after Hello. REQUIRES: arm_count > 0.
absl::Status CheckRequest(const v1::StreamTelemetryRequest& request, uint32_t arm_count);

// Returns whether the request is a message that only a newer protocol has, or has a mode or reason
// that only a newer one has.
bool IsUnknown(const v1::StreamTelemetryRequest& request);

// Returns why no game can have measured this frame, if so. A frame lasts 1 µs (a million FPS) to an
// hour. Detection is part of the frame, within 1 % and 1 ms of clock error. Checks are below 2^60,
// native bytes below 2^46.
std::optional<RejectionReason> RejectionOf(const FrameSample& frame);
// Returns why no shadow lane can have measured this sample, if so. The times are at most an hour;
// the other bounds are those of a frame.
std::optional<RejectionReason> RejectionOf(const ShadowSample& sample);

absl::Status CheckPriorRecord(const v1::PriorRecord& record);

}  // namespace sweepstake::rpc
