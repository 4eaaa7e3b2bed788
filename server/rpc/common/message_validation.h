// What a client's message must satisfy before anything of it is applied. Pure functions; the cost
// is linear in the message.
//
// There are two kinds of errors. A message that breaks the contract (lengths, indices, names,
// absent fields) ends the stream with INVALID_ARGUMENT, or FAILED_PRECONDITION for a wrong order or
// version. A single frame or shadow visit whose values cannot have been measured is left out and
// counted; the rest of its batch is used.
#pragma once

#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "server/decision/types.h"
#include "sweepstake/v1/priors.pb.h"
#include "sweepstake/v1/telemetry.pb.h"

namespace sweepstake::rpc {

// 1–128 bytes of UTF-8 without control characters (protobuf has checked the UTF-8).
bool IsName(std::string_view name);
// As IsName, or empty.
bool IsOptionalName(std::string_view name);

// REQUIRES: a policy is named; the caller has filled in the daemon's default where the client named
// none.
absl::Status CheckHello(const v1::Hello& hello);

// Checks any request after Hello. REQUIRES: arm_count > 0.
absl::Status CheckRequest(const v1::StreamTelemetryRequest& request, uint32_t arm_count);

// False: no game measures this. A frame lasts 1 µs (a million FPS) to an hour. Detection is part of
// the frame, within 1 % and 1 ms of clock error. Checks are below 2^60, native bytes below 2^46.
bool IsPlausible(const decision::Frame& frame);
// False: no shadow lane measures this. The times are at most an hour; the other bounds are those of
// a frame.
bool IsPlausible(const decision::ShadowSample& sample);

absl::Status CheckPriorRecord(const v1::PriorRecord& record);

}  // namespace sweepstake::rpc
