// Asks a server through grpc.health.v1 how it is, as a whole. Thread-safe.
#pragma once

#include <grpcpp/grpcpp.h>

#include <chrono>
#include <memory>
#include <string>

#include "server/tls/tls_files.h"

namespace sweepstake::rpc {

enum class Health { kNoAnswer, kServing, kNotServing };

// Waits for the answer for `patience` at most.
Health HealthOf(const std::shared_ptr<grpc::Channel>& channel, std::chrono::milliseconds patience);

// Asks a daemon at HOST:PORT that serves with these files of TLS, over a TCP connection of its own,
// so that a listener that has died is noticed. It does not matter whose certificate the listener
// has. A daemon that asks clients for one is shown its own: one that it does not accept itself is
// no answer, and neither are files that cannot be read.
Health ProbeHealth(const std::string& address, const tls::Files& files,
                   std::chrono::milliseconds patience);

}  // namespace sweepstake::rpc
