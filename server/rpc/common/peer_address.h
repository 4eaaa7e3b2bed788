// Where a call comes from, as quotas count it. Pure functions.
#pragma once

#include <string>
#include <string_view>

namespace sweepstake::rpc {

// Returns the address in gRPC's name of a peer, without the port. Of IPv6 it is the network of 64
// bits, since one machine may have all of its addresses.
std::string AddressOf(std::string_view peer);

// Returns whether the address of AddressOf is of the daemon's own machine.
bool IsLoopbackAddress(std::string_view address);

}  // namespace sweepstake::rpc
