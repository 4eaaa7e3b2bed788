// What a stream still has to write: of each kind of message the latest only, so that a client that
// reads slowly gets the newest state and costs five messages at most. Not thread-safe.
#pragma once

#include <array>
#include <optional>

#include "sweepstake/v1/telemetry.pb.h"

namespace sweepstake::rpc {

class TelemetryOutbox {
 public:
  // Replaces an unsent message of the same kind. REQUIRES: the response has a message.
  void Put(v1::StreamTelemetryResponse response);
  // The most urgent one: welcome, switch command, acknowledgement, snapshot, reconnect.
  std::optional<v1::StreamTelemetryResponse> Take();
  void Clear() { slots_ = {}; }

 private:
  static constexpr size_t kKinds =
      5;  // of StreamTelemetryResponse.message, numbered from 1 in order of urgency
  std::array<std::optional<v1::StreamTelemetryResponse>, kKinds> slots_;
};

}  // namespace sweepstake::rpc
