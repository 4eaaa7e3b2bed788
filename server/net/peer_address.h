// Where a call comes from: in gRPC's form, and as quotas count it.
#pragma once

#include <string>
#include <string_view>

namespace sweepstake::net {

// Returns who is at the other end of a connected socket, as grpc::ServerContext::peer has it, or
// nothing if that cannot be told.
std::string PeerOf(int descriptor);

// Returns whether both ends of a connected socket have the same IP address, as they have where a
// program connects to an address of its own machine.
bool ConnectsItself(int descriptor);

// Returns the address in gRPC's name of a peer, without the port. Of IPv6 it is the network of 64
// bits, since one machine may have all of its addresses.
std::string AddressOf(std::string_view peer);

// Returns whether the address of AddressOf is of the daemon's own machine.
bool IsLoopbackAddress(std::string_view address);

}  // namespace sweepstake::net
