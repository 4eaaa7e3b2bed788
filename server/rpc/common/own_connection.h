// A connection to a server's services without its listener, for the daemon's HTTP side.
#pragma once

#include <grpcpp/channel.h>
#include <grpcpp/server.h>

#include <memory>
#include <string_view>

#include "absl/status/statusor.h"

namespace sweepstake::rpc {

// Prefix of gRPC's peer name for such a connection; network connections have other prefixes.
inline constexpr std::string_view kOwnPeer = "fd:";

// Connects to the server by a socket pair that no other process can reach. (gRPC 1.51 has an
// in-process transport without sockets. Under load it loses calls and details of errors, and
// sometimes it ends the process.) Messages may have any size. Error: RESOURCE_EXHAUSTED (no
// descriptors are left).
absl::StatusOr<std::shared_ptr<grpc::Channel>> ConnectWithin(grpc::Server& server);

}  // namespace sweepstake::rpc
