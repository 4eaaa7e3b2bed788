// Accepts TCP connections, for any protocol. While the process has no free file descriptors, it
// keeps trying, and clients wait in the system's queue.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <deque>
#include <functional>
#include <string>
#include <utility>

#include "absl/status/status.h"

namespace sweepstake::net {

// Only one thread at a time may run `io` and use this object.
class TcpAcceptor {
 public:
  using OnConnection = std::function<void(boost::asio::ip::tcp::socket)>;

  // `on_connection` is called by the thread that runs `io`. `retry` is the time between two
  // attempts to accept while there are no free descriptors.
  TcpAcceptor(boost::asio::io_context& io, std::chrono::milliseconds retry,
              OnConnection on_connection)
      : io_(io), retry_(retry), on_connection_(std::move(on_connection)) {}

  // Listens on each address that `listen` resolves to. `listen` is HOST:PORT, with brackets around
  // an IPv6 address; port 0 means any free port. Error: UNAVAILABLE (cannot listen there).
  absl::Status Listen(const std::string& listen);
  int port() const { return sockets_.front().acceptor.local_endpoint().port(); }

  // Between Pause and Resume at most one more connection per address is accepted.
  void Pause() { paused_ = true; }
  void Resume();
  // Accepts no further connections.
  void Close();

 private:
  struct Socket {
    boost::asio::ip::tcp::acceptor acceptor;
    boost::asio::steady_timer retry;
    bool waits_for_resume = false;
  };

  // Throws boost::system::system_error.
  void Open(const std::string& listen);
  void Accept(Socket& socket);
  void OnAccepted(Socket& socket, boost::system::error_code error,
                  boost::asio::ip::tcp::socket connection);

  boost::asio::io_context& io_;
  const std::chrono::milliseconds retry_;
  const OnConnection on_connection_;
  std::deque<Socket> sockets_;  // a deque, because handlers hold references
  bool paused_ = false;
  bool closed_ = false;
};

}  // namespace sweepstake::net
