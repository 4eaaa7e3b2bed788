// Converts messages to and from the protobuf wire format without the protobuf library. A client
// encodes requests and decodes responses. The encoded bytes are the same as protobuf's.
//
// Pure functions. The only exception that they throw is std::bad_alloc.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "engine_client/telemetry/protocol/messages.h"

namespace sweepstake::protocol {

// Return a StreamTelemetryRequest without a sequence number. Hello, Goodbye and BoxView are
// complete. The other messages need Numbered.
std::string Encode(const Hello& hello);
std::string Encode(const FrameBatch& batch);
std::string Encode(const SwitchOutcome& outcome);
std::string Encode(const BailOut& bail_out);
std::string Encode(const ModeChange& change);
std::string Encode(const Goodbye& goodbye);
std::string Encode(const OrderRefusal& refusal);
std::string Encode(const BoxView& view);

// Returns the encoded message with its sequence number added. Evidence is stored without a number,
// so it can be renumbered without encoding it again. REQUIRES: sequence > 0.
std::string Numbered(uint64_t sequence, std::string_view encoded);

// Decodes a StreamTelemetryResponse. Skips fields of a newer protocol. Returns nullopt if the bytes
// are not a valid message, or if a text in it is not UTF-8 or has control characters.
std::optional<Response> DecodeResponse(std::string_view bytes);

// The status with which the daemon ended a call.
struct DaemonStatus {
  uint32_t code = 0;    // of gRPC
  std::string message;  // any bytes
  std::string reason;   // the name of the ErrorReason (errors.proto) without its prefix
};

// Returns the status in the bytes of grpc-status-details-bin; nothing if it has no ErrorReason.
// Prefer it to gRPC's own status: if a proxy resets the stream, that has the code and the message
// of the reset.
std::optional<DaemonStatus> StatusIn(std::string_view status_details);

}  // namespace sweepstake::protocol
