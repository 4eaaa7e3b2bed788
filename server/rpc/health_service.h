// grpc.health.v1: Check and Watch of the whole daemon, which has the empty service name. No token
// is needed. It replaces gRPC's own service, because that does not limit the watches. Thread-safe.
#pragma once

#include <grpcpp/generic/async_generic_service.h>

#include <cstddef>
#include <memory>
#include <mutex>
#include <set>
#include <string_view>

namespace sweepstake::rpc {

class HealthService {
 public:
  // Further watches are refused with RESOURCE_EXHAUSTED.
  static constexpr size_t kMaxWatches = 100;

  // Sends the new health to all watches.
  void Set(bool is_serving);
  // Reports NOT_SERVING from now on, and ends all watches.
  void ShutDown();
  // Serves a call. Returns null if the path is not that of a health method.
  grpc::ServerGenericBidiReactor* Serve(std::string_view path);

 private:
  class Call;
  class CheckCall;
  class WatchCall;

  bool is_serving() const;
  // Returns false if there are too many watches.
  bool Add(const std::shared_ptr<WatchCall>& watch);
  void Remove(const std::shared_ptr<WatchCall>& watch);

  mutable std::mutex mutex_;
  bool is_serving_ = true;                        // guarded by mutex_
  bool is_down_ = false;                          // guarded by mutex_
  std::set<std::shared_ptr<WatchCall>> watches_;  // guarded by mutex_
};

}  // namespace sweepstake::rpc
