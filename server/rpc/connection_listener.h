// Accepts the connections of the gRPC server, on a thread of its own.
//
// The listener of gRPC 1.51 stops permanently after one failed accept, for instance if there are no
// free descriptors. This listener tries again.
#pragma once

#include <grpcpp/server_builder.h>

#include <boost/asio/io_context.hpp>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "absl/status/status.h"
#include "server/net/tcp_acceptor.h"
#include "server/rpc/common/refusal_log.h"
#include "server/rpc/connection_calls.h"
#include "server/rpc/open_connections.h"

namespace sweepstake::rpc {

class ConnectionListener {
 public:
  // After Listen, `grpc` receives the connections. REQUIRES: the server of `grpc` has been started
  // before Listen. Each connection is registered with `calls`. If `open` refuses a connection, it
  // is closed and logged in `refusals`, which is borrowed.
  ConnectionListener(std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> grpc,
                     std::shared_ptr<ConnectionCalls> calls, OpenConnections open,
                     RefusalLog& refusals);
  ~ConnectionListener();
  ConnectionListener(const ConnectionListener&) = delete;
  ConnectionListener& operator=(const ConnectionListener&) = delete;

  // `address` is HOST:PORT; port 0 means any free port. Error: UNAVAILABLE (cannot listen there).
  absl::Status Listen(const std::string& address);
  int port() const { return acceptor_.port(); }

 private:
  void HandOver(boost::asio::ip::tcp::socket connection);

  const std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> grpc_;
  const std::shared_ptr<ConnectionCalls> calls_;
  OpenConnections open_;  // used on thread_
  RefusalLog& refusals_;
  boost::asio::io_context io_{1};
  net::TcpAcceptor acceptor_;
  std::thread thread_;  // last: it uses the members above
};

}  // namespace sweepstake::rpc
