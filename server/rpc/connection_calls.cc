#include "server/rpc/connection_calls.h"

#include <arpa/inet.h>
#include <grpcpp/server_context.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <utility>

#include "absl/strings/str_cat.h"

namespace sweepstake::rpc {
namespace {

// Returns who is at the other end, in gRPC's form, or nothing if that cannot be told.
std::string PeerOf(int descriptor) {
  sockaddr_in6 address{};  // an IPv4 one is smaller
  socklen_t size = sizeof address;
  if (getpeername(descriptor, reinterpret_cast<sockaddr*>(&address), &size) != 0) return {};
  std::array<char, INET6_ADDRSTRLEN> text{};
  const uint16_t port = ntohs(address.sin6_port);  // in the same place in both
  if (address.sin6_family == AF_INET) {
    const auto& ipv4 = reinterpret_cast<const sockaddr_in&>(address).sin_addr;
    inet_ntop(AF_INET, &ipv4, text.data(), text.size());
    return absl::StrCat("ipv4:", text.data(), ":", port);
  }
  if (IN6_IS_ADDR_V4MAPPED(&address.sin6_addr)) {
    inet_ntop(AF_INET, &address.sin6_addr.s6_addr[12], text.data(), text.size());
    return absl::StrCat("ipv4:", text.data(), ":", port);
  }
  inet_ntop(AF_INET6, &address.sin6_addr, text.data(), text.size());
  return absl::StrCat("ipv6:%5B", text.data(), "%5D:", port);
}

// Ends a connection for both sides. gRPC finds nothing more in it, of which there may be megabytes.
void Abort(int descriptor) {
  shutdown(descriptor, SHUT_RDWR);
  std::array<char, 16 * 1024> unread;
  while (recv(descriptor, unread.data(), unread.size(), MSG_DONTWAIT) > 0) {
  }
}

// Counts one call as long as it lives, which is as long as the call does.
class CountedCall final : public grpc::experimental::Interceptor {
 public:
  CountedCall(std::shared_ptr<ConnectionCalls> calls, const std::string& peer)
      : calls_(std::move(calls)), connection_(calls_->Begin(peer)) {
    made_.store(true, std::memory_order_release);
  }
  ~CountedCall() override {
    if (made_.load(std::memory_order_acquire) && connection_) calls_->End(*connection_);
  }
  void Intercept(grpc::experimental::InterceptorBatchMethods* methods) override {
    methods->Proceed();
  }

 private:
  const std::shared_ptr<ConnectionCalls> calls_;
  const std::shared_ptr<ConnectionCalls::Connection> connection_;
  // gRPC orders what its threads do; ThreadSanitizer, which does not see that, sees this.
  std::atomic<bool> made_{false};
};

class CallCounter final : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  explicit CallCounter(std::shared_ptr<ConnectionCalls> calls) : calls_(std::move(calls)) {}
  grpc::experimental::Interceptor* CreateServerInterceptor(
      grpc::experimental::ServerRpcInfo* info) override {
    return new CountedCall(calls_, info->server_context()->peer());
  }

 private:
  const std::shared_ptr<ConnectionCalls> calls_;
};

}  // namespace

void ConnectionCalls::Add(int descriptor) {
  const auto connection = std::make_shared<Connection>(
      Connection{.descriptor = descriptor, .peer = PeerOf(descriptor)});
  const std::lock_guard lock(mutex_);
  std::shared_ptr<Connection>& slot = by_descriptor_[descriptor];
  if (slot) {
    const auto former = by_peer_.find(slot->peer);
    if (former != by_peer_.end() && former->second == slot) by_peer_.erase(former);
  }
  slot = connection;
  by_peer_[connection->peer] = connection;
}

std::shared_ptr<ConnectionCalls::Connection> ConnectionCalls::Begin(const std::string& peer) {
  const std::lock_guard lock(mutex_);
  const auto found = by_peer_.find(peer);
  if (found == by_peer_.end()) return nullptr;
  const std::shared_ptr<Connection> connection = found->second;
  if (++connection->call_count > max_calls_ && !std::exchange(connection->ended, true)) {
    ++ended_count_;
    // gRPC may have closed the descriptor already; then it may be of something else by now.
    if (PeerOf(connection->descriptor) == peer) Abort(connection->descriptor);
  }
  return connection;
}

void ConnectionCalls::End(Connection& connection) {
  const std::lock_guard lock(mutex_);
  --connection.call_count;
}

std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> CountCalls(
    std::shared_ptr<ConnectionCalls> calls) {
  return std::make_unique<CallCounter>(std::move(calls));
}

}  // namespace sweepstake::rpc
