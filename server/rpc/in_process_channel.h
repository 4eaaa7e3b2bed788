// The way to a server's services without a connection, for the daemon's HTTP side.
//
// A call that begins on such a channel of gRPC 1.51 after its server has shut down ends the
// process. Calls therefore begin through this, which the server closes first. Thread-safe.
#pragma once

#include <grpcpp/channel.h>

#include <functional>
#include <memory>
#include <mutex>
#include <utility>

namespace sweepstake::rpc {

class InProcessChannel {
 public:
  using Begin = std::function<void(const std::shared_ptr<grpc::Channel>&)>;

  explicit InProcessChannel(std::shared_ptr<grpc::Channel> channel)
      : channel_(std::move(channel)) {}

  // Has a call begun. Returns false, and does nothing, once the server ends. Calls that have begun
  // go on.
  bool Use(const Begin& begin) {
    const std::lock_guard lock(mutex_);
    if (channel_ != nullptr) begin(channel_);
    return channel_ != nullptr;
  }
  void Close() {
    const std::lock_guard lock(mutex_);
    channel_.reset();
  }

 private:
  std::mutex mutex_;
  std::shared_ptr<grpc::Channel> channel_;  // guarded by mutex_; null once it is closed
};

}  // namespace sweepstake::rpc
