#include "server/rpc/connection_listener.h"

#include <netinet/tcp.h>

#include <chrono>

namespace sweepstake::rpc {
namespace {

using boost::asio::ip::tcp;

constexpr std::chrono::milliseconds kAcceptRetry{100};
// A connection ends whose peer has not taken what was sent for so long, as gRPC's own listener has
// it with the keepalive of SetLimits.
constexpr int kSendPatienceMs = 20'000;
// While the system has more of a connection, gRPC reads on before it begins the calls that it has
// read, and before ConnectionCalls can count them. So the system keeps little.
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
  // A connection that has ended already refuses these; gRPC notices that by itself.
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
