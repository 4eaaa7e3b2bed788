// Accepts the connections of the gRPC server and copies their bytes, on a thread of its own.
//
// The listener of gRPC 1.51 stops permanently after one failed accept, for instance if there are no
// free descriptors. This listener tries again. It puts a guard in front of each connection
// (guarded_connection.h). New connections use the certificate that the TLS files have now. While
// these cannot be used, the former one stays.
#pragma once

#include <grpcpp/server_builder.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "absl/status/status.h"
#include "server/net/http2_guard.h"
#include "server/net/tcp_acceptor.h"
#include "server/rpc/common/options.h"
#include "server/rpc/common/refusal_log.h"
#include "server/rpc/open_connections.h"
#include "server/sessions/common/decision_loop.h"
#include "server/tls/certificate.h"

namespace sweepstake::rpc {

class GuardedConnection;

class ConnectionListener {
 public:
  // After Listen, `grpc` receives the connections. REQUIRES: the server of `grpc` has been started
  // before Listen. Connections of an address that has too many are closed. These and the calls that
  // the guard ends are counted and logged. References are borrowed.
  ConnectionListener(std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> grpc,
                     const RpcOptions& options, const sessions::LoopClock& clock,
                     Counters& counters, RefusalLog& refusals);
  // Ends all connections.
  ~ConnectionListener();
  ConnectionListener(const ConnectionListener&) = delete;
  ConnectionListener& operator=(const ConnectionListener&) = delete;

  // `address` is HOST:PORT; port 0 means any free port. Errors: UNAVAILABLE (cannot listen there),
  // INVALID_ARGUMENT (the TLS files of the options cannot be used).
  absl::Status Listen(const std::string& address);
  int port() const { return port_; }
  // Accepts no further connections. The existing ones continue.
  void StopAccepting();
  // Waits until the clients have got what gRPC has sent, at most for `patience`. Call it after
  // gRPC's server has ended.
  void AwaitEnd(std::chrono::milliseconds patience);

 private:
  // The functions below run on thread_.
  void HandOver(boost::asio::ip::tcp::socket client);
  net::Http2Guard::Headers OnRefusal(const std::string& peer, net::Http2Refusal why);
  // Runs once per second.
  void Look();
  void CountOpen();

  const std::unique_ptr<grpc::experimental::ExternalConnectionAcceptor> grpc_;
  const sessions::LoopClock& clock_;
  Counters& counters_;
  RefusalLog& refusals_;
  tls::Certificate certificate_;
  const std::shared_ptr<net::Http2Use> use_ = std::make_shared<net::Http2Use>();
  OpenConnections open_;
  int port_ = 0;
  uint64_t connection_count_ = 0;  // accepted so far
  std::map<uint64_t, std::weak_ptr<GuardedConnection>> connections_;
  std::mutex mutex_;
  std::condition_variable ended_;
  size_t open_count_ = 0;  // of connections_; guarded by mutex_
  boost::asio::io_context io_{1};
  boost::asio::steady_timer second_{io_};
  net::TcpAcceptor acceptor_;
  std::thread thread_;  // last: it uses the members above
};

}  // namespace sweepstake::rpc
