// Asks a server through grpc.health.v1 how it is, as a whole. Thread-safe.
#pragma once

#include <grpcpp/grpcpp.h>

#include <chrono>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "engine_client/telemetry/tls/tls_files.h"

namespace sweepstake::rpc {

enum class Health { kServing, kNotServing };

// Waits for the answer for `patience` at most. Error: UNAVAILABLE (there is no answer, and why).
absl::StatusOr<Health> HealthOf(const std::shared_ptr<grpc::Channel>& channel,
                                std::chrono::milliseconds patience);

// Asks a daemon at HOST:PORT that serves with these files of TLS, over a TCP connection of its own,
// so that a listener that has died is noticed. It does not matter whose certificate the listener
// has. A daemon that asks clients for one is shown its own. Errors: those of HealthOf, with what to
// do where the certificate is to blame, and those of tls::Read.
absl::StatusOr<Health> ProbeHealth(const std::string& address, const tls::Files& files,
                                   std::chrono::milliseconds patience);

}  // namespace sweepstake::rpc
