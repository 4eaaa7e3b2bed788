#include "server/rpc/connection_listener.h"

#include <netinet/tcp.h>

#include <chrono>

namespace sweepstake::rpc {
namespace {

using boost::asio::ip::tcp;

// Pause after an accept that failed because no descriptors were free.
constexpr std::chrono::milliseconds kAcceptRetry{100};
// TCP_USER_TIMEOUT: closes a connection if the peer has not acknowledged sent data for this time.
// gRPC's own listener sets it to the keepalive timeout of SetLimits.
constexpr int kSendPatienceMs = 20'000;
// gRPC first reads all bytes that the system has received on a connection, and only then starts the
// calls in them. Until then ConnectionCalls cannot count these calls. A small receive buffer limits
// their number.
constexpr int kReceiveBufferBytes = 32 * 1024;
using SendPatience = boost::asio::detail::socket_option::integer<IPPROTO_TCP, TCP_USER_TIMEOUT>;

}  // namespace

ConnectionListener::ConnectionListener(
    std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> grpc,
    std::shared_ptr<ConnectionCalls> calls, OpenConnections open, RefusalLog& refusals)
    : grpc_(std::move(grpc)),
      calls_(std::move(calls)),
      open_(std::move(open)),
      refusals_(refusals),
      acceptor_(io_, kAcceptRetry,
                [this](tcp::socket connection) { HandOver(std::move(connection)); }) {}

ConnectionListener::~ConnectionListener() {
  io_.stop();
  if (thread_.joinable()) thread_.join();
}

absl::Status ConnectionListener::Listen(const std::string& address) {
  if (absl::Status status = acceptor_.Listen(address); !status.ok()) return status;
  thread_ = std::thread([this] { io_.run(); });
  return absl::OkStatus();
}

void ConnectionListener::HandOver(tcp::socket connection) {
  if (const absl::Status admitted = open_.Add(connection.native_handle()); !admitted.ok())
    return refusals_.Tell(net::PeerOf(connection.native_handle()), admitted);
  // These calls fail if the connection has already ended; gRPC detects that by itself.
  boost::system::error_code ignored;
  connection.native_non_blocking(true, ignored);
  connection.set_option(tcp::no_delay(true), ignored);
  connection.set_option(SendPatience(kSendPatienceMs), ignored);
  connection.set_option(tcp::socket::receive_buffer_size(kReceiveBufferBytes), ignored);
  grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters parameters;
  parameters.fd = connection.release(ignored);
  calls_->Add(parameters.fd);
  grpc_->HandleNewConnection(&parameters);
}

}  // namespace sweepstake::rpc
