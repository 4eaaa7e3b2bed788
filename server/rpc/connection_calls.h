// Counts the unfinished calls of each connection, and ends a connection that has too many of them.
//
// HTTP/2 limits the open streams of a connection. A client that resets each stream at once may
// start the next one before the server has finished the previous call. gRPC 1.51 does not limit
// such calls: a single connection made it use 1.7 GB in 20 seconds. If many connections do so at
// once and all processors are busy, the calls are counted too late. HAProxy in front of the daemon
// prevents that.
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

// Thread-safe. The size of the tables is bounded by the process's limit of file descriptors.
class ConnectionCalls {
 public:
  // A connection that begins more than `max_calls` unfinished calls is ended, and counted in
  // `ended_count`. gRPC does not report the connection of a call. If two connections to two
  // addresses of the daemon have the same peer address and port, they are counted together and
  // ended together.
  ConnectionCalls(uint32_t max_calls, std::atomic<uint64_t>& ended_count)
      : max_calls_(max_calls), ended_count_(ended_count) {}

  // Registers an accepted connection. gRPC closes the descriptor later.
  void Add(int descriptor);

  // The remote end of one or more connections. mutex_ guards all fields except the name.
  struct RemoteEnd {
    const std::string name;
    std::set<int> descriptors;
    uint32_t call_count = 0;
    bool ended = false;
  };
  // Counts a new call of a peer, and returns the peer; null if it is unknown. Pass the peer to End
  // when the call has ended. `name` has the format of grpc::ServerContext::peer.
  std::shared_ptr<RemoteEnd> Begin(const std::string& name);
  void End(RemoteEnd& peer);

 private:
  const uint32_t max_calls_;
  std::atomic<uint64_t>& ended_count_;
  std::mutex mutex_;
  // mutex_ guards both maps. A connection stays in them until its descriptor is reused.
  std::unordered_map<int, std::shared_ptr<RemoteEnd>> by_descriptor_;
  std::unordered_map<std::string, std::shared_ptr<RemoteEnd>> by_name_;
};

// Returns an interceptor factory that counts every call of a server, including calls of gRPC's own
// services.
std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> CountCalls(
    std::shared_ptr<ConnectionCalls> calls);

}  // namespace sweepstake::rpc
