#include "server/rpc/connection_listener.h"

#include <netinet/tcp.h>
#include <unistd.h>

#include <boost/asio/post.hpp>
#include <chrono>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "server/net/peer_address.h"
#include "server/rpc/common/error_reasons.h"
#include "server/rpc/guarded_connection.h"

namespace sweepstake::rpc {
namespace {

using boost::asio::ip::tcp;

// Pause after an accept that failed because no descriptors were free.
constexpr std::chrono::milliseconds kAcceptRetry{100};
// TCP_USER_TIMEOUT: closes a connection if the peer has not acknowledged sent data for this time.
// gRPC's own listener sets it to the keepalive timeout of SetLimits.
constexpr int kSendPatienceMs = 20'000;
using SendPatience = boost::asio::detail::socket_option::integer<IPPROTO_TCP, TCP_USER_TIMEOUT>;

// The status of a call that the guard ends. Connections that it closes get none, but it is logged.
absl::Status StatusOf(net::Http2Refusal why) {
  switch (why) {
    case net::Http2Refusal::kLongMessage:
      return Refused(v1::ERROR_REASON_MESSAGE_TOO_LONG,
                     absl::StrCat("the call announced a message of more than ", kMaxMessageBytes,
                                  " bytes, the maximum; send shorter messages"));
    case net::Http2Refusal::kCompressedMessage:
      return Refused(v1::ERROR_REASON_MESSAGE_COMPRESSED,
                     "the daemon reads no compressed messages; send plain ones");
    case net::Http2Refusal::kWaitingBytes:
      return Refused(v1::ERROR_REASON_TOO_MANY_STREAMS,
                     "too many bytes of incomplete messages wait; send them one after another");
    case net::Http2Refusal::kLateMessage:
      return Refused(v1::ERROR_REASON_CALL_STALLED,
                     "the first message of the call did not arrive in time; call again");
    case net::Http2Refusal::kWaitingCalls:
      return Refused(v1::ERROR_REASON_TOO_MANY_STREAMS,
                     "a connection has too many calls that wait for their first message");
    case net::Http2Refusal::kResets:
      return Refused(v1::ERROR_REASON_TOO_MANY_STREAMS, "a connection cancelled too many calls");
    case net::Http2Refusal::kRefusals:
      return Refused(v1::ERROR_REASON_TOO_MANY_STREAMS,
                     "too many calls of a connection were refused");
    case net::Http2Refusal::kNotHttp2:
      break;
  }
  return Refused(v1::ERROR_REASON_MALFORMED_MESSAGE, "a connection sent bytes that are not HTTP/2");
}

bool EndsConnection(net::Http2Refusal why) {
  return why == net::Http2Refusal::kWaitingCalls || why == net::Http2Refusal::kResets ||
         why == net::Http2Refusal::kRefusals || why == net::Http2Refusal::kNotHttp2;
}

}  // namespace

ConnectionListener::ConnectionListener(
    std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> grpc, const RpcOptions& options,
    const sessions::LoopClock& clock, Counters& counters, RefusalLog& refusals)
    : grpc_(std::move(grpc)),
      clock_(clock),
      counters_(counters),
      refusals_(refusals),
      certificate_(options.tls, tls::Protocol::kHttp2),
      open_(options),
      acceptor_(io_, kAcceptRetry, [this](tcp::socket client) { HandOver(std::move(client)); }) {}

ConnectionListener::~ConnectionListener() {
  io_.stop();
  if (thread_.joinable()) thread_.join();
}

absl::Status ConnectionListener::Listen(const std::string& address) {
  if (absl::Status status = certificate_.Read(); !status.ok()) return status;
  if (absl::Status status = acceptor_.Listen(address); !status.ok()) return status;
  port_ = acceptor_.port();
  Look();
  thread_ = std::thread([this] { io_.run(); });
  return absl::OkStatus();
}

void ConnectionListener::StopAccepting() {
  boost::asio::post(io_, [this] { acceptor_.Close(); });
}

void ConnectionListener::AwaitEnd(std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  ended_.wait_for(lock, patience, [this] { return open_count_ == 0; });
}

void ConnectionListener::CountOpen() {
  {
    const std::lock_guard lock(mutex_);
    open_count_ = connections_.size();
  }
  ended_.notify_all();
}

void ConnectionListener::HandOver(tcp::socket client) {
  const std::string peer = net::PeerOf(client.native_handle());
  auto address = open_.Add(peer, net::ConnectsItself(client.native_handle()));
  if (!address.ok()) return refusals_.Tell(peer, address.status());
  // These calls fail if the connection has already ended, which the first read shows.
  boost::system::error_code ignored;
  client.set_option(tcp::no_delay(true), ignored);
  client.set_option(SendPatience(kSendPatienceMs), ignored);
  const uint64_t number = ++connection_count_;
  const auto connection = GuardedConnection::Make(
      std::move(client), net::LocalNameOf(peer, number), certificate_.context(), use_,
      [this, peer](net::Http2Refusal why) { return OnRefusal(peer, why); });
  if (!connection.ok()) {
    open_.Remove(*address);
    return refusals_.Tell(peer, connection.status());
  }
  connections_.emplace(number, *connection);
  CountOpen();
  grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters parameters;
  parameters.fd = (*connection)->TakeServerEnd();
  grpc_->HandleNewConnection(&parameters);
  (*connection)
      ->Start([this] { return clock_.NowNs(); },
              [this, number, address = *address] {
                connections_.erase(number);
                CountOpen();
                open_.Remove(address);
              });
}

net::Http2Guard::Headers ConnectionListener::OnRefusal(const std::string& peer,
                                                       net::Http2Refusal why) {
  ++(EndsConnection(why) ? counters_.refused_connection_count : counters_.unread_call_count);
  const absl::Status status = StatusOf(why);
  refusals_.Tell(peer, status);
  const grpc::Status answer = ToGrpc(status, counters_);
  net::Http2Guard::Headers headers = {
      {"grpc-status", absl::StrCat(static_cast<int>(answer.error_code()))},
      {"grpc-message", answer.error_message()}};
  if (!answer.error_details().empty())
    headers.emplace_back("grpc-status-details-bin", absl::Base64Escape(answer.error_details()));
  return headers;
}

void ConnectionListener::Look() {
  certificate_.Read().IgnoreError();  // the daemon's FilesWatch reports it
  // EndLateCalls may end a connection, which removes it from connections_.
  for (auto next = connections_.begin(); next != connections_.end();) {
    const std::shared_ptr<GuardedConnection> connection = (next++)->second.lock();
    if (connection) connection->EndLateCalls();
  }
  second_.expires_after(std::chrono::seconds(1));
  second_.async_wait([this](const boost::system::error_code& error) {
    if (!error) Look();
  });
}

}  // namespace sweepstake::rpc
