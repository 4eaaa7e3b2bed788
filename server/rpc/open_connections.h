// Limits the open connections per remote address.
//
// gRPC closes the descriptors of its connections without notice. If an address reaches the limit,
// its descriptors are checked. A descriptor whose peer has changed was closed or belongs to another
// connection.
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

// Used by one thread. The size of the tables is bounded by the process's limit of file descriptors.
class OpenConnections {
 public:
  using NameOf = std::function<std::string(int)>;
  using IsOwn = std::function<bool(int)>;

  // Connections per address in addition to max_streams_per_address: for watchers, and for lost
  // connections that the daemon has not noticed yet.
  static constexpr uint32_t kSpare = 1'000;
  // Minimum time between two checks of the descriptors of one address.
  static constexpr int64_t kLookIntervalNs = 1'000'000'000;

  // `options` and `clock` are borrowed. `name_of` returns the peer of a descriptor. `is_own`
  // returns whether the peer is on the daemon's own machine, at any of its addresses.
  OpenConnections(const RpcOptions& options, const sessions::LoopClock& clock,
                  NameOf name_of = net::PeerOf, IsOwn is_own = net::ConnectsItself)
      : options_(options),
        clock_(clock),
        name_of_(std::move(name_of)),
        is_own_(std::move(is_own)) {}

  // Registers an accepted connection. Error: RESOURCE_EXHAUSTED (its address already has
  // RpcOptions::max_streams_per_address + kSpare connections); then the caller closes the
  // connection. Connections from the daemon's own machine are not limited.
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

  // Removes the registered connection of the descriptor, if there is one.
  void Forget(int descriptor);
  // Removes the closed connections of the address. Returns how many are left.
  size_t CountOpen(const std::string& address);

  const RpcOptions& options_;
  const sessions::LoopClock& clock_;
  const NameOf name_of_;
  const IsOwn is_own_;
  std::unordered_map<int, Connection> connections_;
  std::unordered_map<std::string, Address> addresses_;  // the addresses of connections_
};

}  // namespace sweepstake::rpc
