// Converts messages to and from the protobuf wire format without the protobuf library. A client
// encodes requests and decodes responses. Encoding gives the same bytes as protobuf.
//
// Pure functions; the only exception that they throw is std::bad_alloc.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "engine_client/telemetry/protocol/messages.h"

namespace sweepstake::protocol {

// Returns a StreamTelemetryRequest without its sequence number. It is complete for Hello, Goodbye
// and BoxView; Numbered completes the others.
std::string Encode(const Hello& hello);
std::string Encode(const FrameBatch& batch);
std::string Encode(const SwitchOutcome& outcome);
std::string Encode(const BailOut& bail_out);
std::string Encode(const ModeChange& change);
std::string Encode(const Goodbye& goodbye);
std::string Encode(const OrderRefusal& refusal);
std::string Encode(const BoxView& view);

// Returns the message with its sequence number. Evidence is stored without its number, so that it
// can be renumbered without being encoded again. REQUIRES: sequence > 0.
std::string Numbered(uint64_t sequence, std::string_view encoded);

// Decodes a StreamTelemetryResponse. Returns nullopt if the bytes are not a valid message, or if a
// text in it is not UTF-8 or has control characters. Skips fields of a newer protocol.
std::optional<Response> DecodeResponse(std::string_view bytes);

// Returns the name of the ErrorReason (errors.proto), without its prefix, in the bytes of
// grpc-status-details-bin; empty if there is none.
std::string ErrorReasonIn(std::string_view status_details);

}  // namespace sweepstake::protocol
