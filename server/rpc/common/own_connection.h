// The way to a server's services without its listener, for the daemon's HTTP side.
#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/server.h>

#include <memory>
#include <string_view>

#include "absl/status/statusor.h"

namespace sweepstake::rpc {

// How gRPC's name of the other end of such a connection begins; those over a network have another
// scheme.
inline constexpr std::string_view kOwnPeer = "fd:";

// Connects to the server by a pair of sockets that nobody else can reach. (gRPC 1.51 has a
// transport for this that needs no sockets; under load it loses calls and details of errors, and at
// times it ends the process.) Messages of any size come through. Errors: RESOURCE_EXHAUSTED (no
// descriptors are left).
absl::StatusOr<std::shared_ptr<grpc::Channel>> ConnectWithin(grpc::Server& server);

}  // namespace sweepstake::rpc
