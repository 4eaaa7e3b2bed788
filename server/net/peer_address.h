// The remote address of a call, in gRPC's format and in the format used by quotas.
#pragma once

#include <cstdint>
#include <optional>
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

// Returns the network of a gRPC peer name: the first 24 bits of an IPv4 address ("203.0.113.0/24"),
// the first 48 bits of an IPv6 address ("2001:db8::/48"). Each has about 256 customers of a
// provider, because one customer often gets 256 networks of 64 bits. Empty for the daemon's own
// machine, because games behind a proxy on this machine all have its address, and for peers without
// an IP address.
std::string NetworkOf(std::string_view peer);
// Returns the network of an address or network that a person has written, such as "203.0.113.7" or
// "2001:db8::/48"; absent if the text is neither.
std::optional<std::string> NetworkNamed(std::string_view text);

// Returns the peer of a request that a proxy on the daemon's machine has forwarded: the last
// address in its header x-forwarded-for, in gRPC's format with the port 0. Returns `peer` if it is
// another machine or there is no header, and the address 0.0.0.0 if the header has no address.
std::string ForwardedPeer(std::string_view peer, std::string_view forwarded_for);

// Returns whether an address returned by AddressOf is on the daemon's own machine.
bool IsLoopbackAddress(std::string_view address);

}  // namespace sweepstake::net
