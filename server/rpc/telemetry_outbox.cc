#include "server/rpc/telemetry_outbox.h"

#include <utility>

namespace sweepstake::rpc {

void TelemetryOutbox::Put(v1::StreamTelemetryResponse response) {
  slots_.at(static_cast<size_t>(response.message_case()) - 1) = std::move(response);
}

std::optional<v1::StreamTelemetryResponse> TelemetryOutbox::Take() {
  for (auto& slot : slots_) {
    if (slot) return std::exchange(slot, std::nullopt);
  }
  return std::nullopt;
}

}  // namespace sweepstake::rpc
