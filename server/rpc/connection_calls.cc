#include "server/rpc/connection_calls.h"

#include <grpcpp/server_context.h>
#include <sys/socket.h>

#include <array>
#include <utility>

#include "server/net/peer_address.h"

namespace sweepstake::rpc {
namespace {

// Shuts the connection down in both directions and drains it. Otherwise gRPC would still process
// the unread bytes, which may be megabytes.
void Abort(int descriptor) {
  shutdown(descriptor, SHUT_RDWR);
  std::array<char, 16 * 1024> unread;
  while (recv(descriptor, unread.data(), unread.size(), MSG_DONTWAIT) > 0) {
  }
}

// Counts one call from its construction to its destruction. gRPC destroys this object together with
// the call.
class CountedCall final : public grpc::experimental::Interceptor {
 public:
  CountedCall(std::shared_ptr<ConnectionCalls> calls, const std::string& peer)
      : calls_(std::move(calls)), peer_(calls_->Begin(peer)) {
    made_.store(true, std::memory_order_release);
  }
  ~CountedCall() override {
    if (made_.load(std::memory_order_acquire) && peer_) calls_->End(*peer_);
  }
  void Intercept(grpc::experimental::InterceptorBatchMethods* methods) override {
    methods->Proceed();
  }

 private:
  const std::shared_ptr<ConnectionCalls> calls_;
  const std::shared_ptr<ConnectionCalls::RemoteEnd> peer_;
  // gRPC orders the constructor before the destructor in a way that ThreadSanitizer cannot see. The
  // store and load of this atomic make the order visible.
  std::atomic<bool> made_{false};
};

class CallCounter final : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  explicit CallCounter(std::shared_ptr<ConnectionCalls> calls) : calls_(std::move(calls)) {
    made_.store(true, std::memory_order_release);
  }
  grpc::experimental::Interceptor* CreateServerInterceptor(
      grpc::experimental::ServerRpcInfo* info) override {
    made_.load(std::memory_order_acquire);
    return new CountedCall(calls_, info->server_context()->peer());
  }

 private:
  const std::shared_ptr<ConnectionCalls> calls_;
  // Shows ThreadSanitizer that the constructor ends before CreateServerInterceptor is called, like
  // CountedCall::made_.
  std::atomic<bool> made_{false};
};

}  // namespace

void ConnectionCalls::Add(int descriptor) {
  const std::string name = net::PeerOf(descriptor);
  const std::lock_guard lock(mutex_);
  std::shared_ptr<RemoteEnd>& slot = by_descriptor_[descriptor];
  if (slot) {
    slot->descriptors.erase(descriptor);
    const auto former = by_name_.find(slot->name);
    if (slot->descriptors.empty() && former != by_name_.end() && former->second == slot)
      by_name_.erase(former);
  }
  std::shared_ptr<RemoteEnd>& peer = by_name_[name];
  if (!peer) peer = std::make_shared<RemoteEnd>(RemoteEnd{.name = name, .descriptors = {}});
  peer->descriptors.insert(descriptor);
  peer->ended = false;
  slot = peer;
}

std::shared_ptr<ConnectionCalls::RemoteEnd> ConnectionCalls::Begin(const std::string& name) {
  const std::lock_guard lock(mutex_);
  const auto found = by_name_.find(name);
  if (found == by_name_.end()) return nullptr;
  const std::shared_ptr<RemoteEnd> peer = found->second;
  if (++peer->call_count <= max_calls_ || std::exchange(peer->ended, true)) return peer;
  ++ended_count_;
  for (const int descriptor : peer->descriptors) {
    // Check the peer first: gRPC may have closed the descriptor, and the system may have given its
    // number to another socket.
    if (net::PeerOf(descriptor) == name) Abort(descriptor);
  }
  return peer;
}

void ConnectionCalls::End(RemoteEnd& peer) {
  const std::lock_guard lock(mutex_);
  --peer.call_count;
}

std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> CountCalls(
    std::shared_ptr<ConnectionCalls> calls) {
  return std::make_unique<CallCounter>(std::move(calls));
}

}  // namespace sweepstake::rpc
