// Counts the calls of each connection that have begun and are not done, and ends a connection that
// has far too many of them.
//
// HTTP/2 bounds the open streams of a connection. A client that resets each stream at once may
// begin the next one though the server has yet to end the call of the last. gRPC 1.51 does not
// bound those: a single connection made it use 1.7 GB in 20 seconds. Many connections that do so at
// once, on processors that are all busy, are counted too late: HAProxy keeps those away.
#pragma once

#include <grpcpp/support/server_interceptor.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <unordered_map>

namespace sweepstake::rpc {

// Thread-safe. The table is as large as there are descriptors.
class ConnectionCalls {
 public:
  // A connection that begins a call beyond `max_calls` is ended, and counted in `ended_count`. gRPC
  // does not say which one a call came by where two have the same other end, one to each of two
  // addresses of the daemon: they are counted together, and ended together.
  ConnectionCalls(uint32_t max_calls, std::atomic<uint64_t>& ended_count)
      : max_calls_(max_calls), ended_count_(ended_count) {}

  // Takes notice of a connection that is accepted; gRPC closes the descriptor one day.
  void Add(int descriptor);

  // The other end of a connection; all but the name is guarded by mutex_.
  struct Peer {
    const std::string name;
    std::set<int> descriptors;
    uint32_t call_count = 0;
    bool ended = false;
  };
  // Returns the peer of a call that begins, or null if it is not known. `name` as in
  // grpc::ServerContext::peer.
  std::shared_ptr<Peer> Begin(const std::string& name);
  void End(Peer& peer);

 private:
  const uint32_t max_calls_;
  std::atomic<uint64_t>& ended_count_;
  std::mutex mutex_;
  // Both guarded by mutex_. A connection is in them until its descriptor belongs to another.
  std::unordered_map<int, std::shared_ptr<Peer>> by_descriptor_;
  std::unordered_map<std::string, std::shared_ptr<Peer>> by_name_;
};

// Makes every call of a server count, whoever answers it.
std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> CountCalls(
    std::shared_ptr<ConnectionCalls> calls);

}  // namespace sweepstake::rpc
