// Limits the open connections per remote address.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_map>

#include "absl/status/statusor.h"
#include "server/rpc/common/options.h"

namespace sweepstake::rpc {

// Used by one thread.
class OpenConnections {
 public:
  // Connections per address in addition to max_streams_per_address: for watchers, and for lost
  // connections that the daemon has not noticed yet.
  static constexpr uint32_t kSpare = 1'000;

  // `options` is borrowed.
  explicit OpenConnections(const RpcOptions& options) : options_(options) {}

  // Counts an accepted connection of this peer (net::PeerOf). `is_own`: it comes from the daemon's
  // own machine, whose connections are not limited. Returns its address for Remove, or an empty
  // text if it is not counted. Error: RESOURCE_EXHAUSTED (the address already has
  // RpcOptions::max_streams_per_address + kSpare connections).
  absl::StatusOr<std::string> Add(std::string_view peer, bool is_own);
  // Counts the end of a connection.
  void Remove(const std::string& address);

 private:
  const RpcOptions& options_;
  std::unordered_map<std::string, uint32_t> counts_;  // of addresses with open connections
};

}  // namespace sweepstake::rpc
