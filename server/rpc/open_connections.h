// Bounds the connections that an address has open.
//
// gRPC closes the descriptors of its connections without telling anybody. At the bound, and only
// there, those of the address are looked at: one that is closed, or belongs to another connection
// by now, has not the same other end any more.
#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>

#include "absl/status/status.h"
#include "server/net/peer_address.h"
#include "server/rpc/common/options.h"
#include "server/sessions/common/decision_loop.h"

namespace sweepstake::rpc {

// Used by one thread. The table is as large as there are descriptors.
class OpenConnections {
 public:
  using NameOf = std::function<std::string(int)>;
  using IsOwn = std::function<bool(int)>;

  // Beyond the streams that an address may have: those who watch, and connections that are lost
  // without the daemon's knowledge yet.
  static constexpr uint32_t kSpare = 1'000;
  // The least time between two looks at the descriptors of one address.
  static constexpr int64_t kLookIntervalNs = 1'000'000'000;

  // It borrows the first two. `name_of` returns who is at the other end of a descriptor, `is_own`
  // whether that is the daemon's own machine, at whichever of its addresses.
  OpenConnections(const RpcOptions& options, const sessions::Clock& clock,
                  NameOf name_of = net::PeerOf, IsOwn is_own = net::ConnectsItself)
      : options_(options),
        clock_(clock),
        name_of_(std::move(name_of)),
        is_own_(std::move(is_own)) {}

  // Takes notice of a connection that is accepted. Error: RESOURCE_EXHAUSTED (its address, which is
  // not of the daemon's own machine, has kSpare more than RpcOptions::max_streams_per_address
  // already); the caller closes it.
  absl::Status Add(int descriptor);

 private:
  struct Connection {
    std::string name;
    std::string address;
  };
  struct Address {
    std::set<int> descriptors;
    int64_t next_look_ns = INT64_MIN;
  };

  // Forgets the connection that the descriptor was of.
  void Forget(int descriptor);
  // Forgets those of the address that are closed. Returns how many are left.
  size_t CountOpen(const std::string& address);

  const RpcOptions& options_;
  const sessions::Clock& clock_;
  const NameOf name_of_;
  const IsOwn is_own_;
  std::unordered_map<int, Connection> connections_;
  std::unordered_map<std::string, Address> addresses_;  // of those in connections_
};

}  // namespace sweepstake::rpc
