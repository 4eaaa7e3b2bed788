// The remote address of a call, in gRPC's format and in the format used by quotas.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace sweepstake::net {

// Returns the peer of a connected socket in the format of grpc::ServerContext::peer, or an empty
// string if it cannot be determined.
std::string PeerOf(int descriptor);

// Returns the name of the local socket through which gRPC gets the bytes of this peer. `number`
// distinguishes connections of the process.
std::string LocalNameOf(std::string_view peer, uint64_t number);
// Returns the peer of a call: `peer` is what gRPC reports, which may be the name of a local socket.
std::string ClientOf(std::string_view peer);

// Returns whether both ends of a connected socket have the same IP address, as when a program
// connects to an address of its own machine.
bool ConnectsItself(int descriptor);

// Returns the address of a gRPC peer name, without the port. For IPv6 it is the /64 network,
// because one machine may use every address of that network.
std::string AddressOf(std::string_view peer);

// Returns whether an address returned by AddressOf is on the daemon's own machine.
bool IsLoopbackAddress(std::string_view address);

}  // namespace sweepstake::net
