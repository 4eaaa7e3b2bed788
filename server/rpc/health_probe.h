// Reads the health of a whole server through grpc.health.v1. Thread-safe.
#pragma once

#include <grpcpp/grpcpp.h>

#include <chrono>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "engine_client/telemetry/tls/tls_files.h"

namespace sweepstake::rpc {

enum class Health { kServing, kNotServing };

// Waits at most `patience` for the answer. Error: UNAVAILABLE (no answer; the message has the
// reason).
absl::StatusOr<Health> HealthOf(const std::shared_ptr<grpc::Channel>& channel,
                                std::chrono::milliseconds patience);

// Probes a daemon at HOST:PORT that serves with these TLS files, over a new TCP connection, so that
// a dead listener is noticed. The listener's certificate is not verified. If the daemon requires
// client certificates, the probe presents the daemon's own. Errors: those of HealthOf, with advice
// if the cause is known, and those of tls::Read.
absl::StatusOr<Health> ProbeHealth(const std::string& address, const tls::Files& files,
                                   std::chrono::milliseconds patience);

}  // namespace sweepstake::rpc
