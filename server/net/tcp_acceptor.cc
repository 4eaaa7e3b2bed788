#include "server/net/tcp_acceptor.h"

#include <boost/asio/error.hpp>
#include <boost/system/system_error.hpp>
#include <set>

#include "absl/strings/str_cat.h"

namespace sweepstake::net {

using boost::asio::ip::tcp;
using boost::system::error_code;

absl::Status TcpAcceptor::Listen(const std::string& listen) {
  try {
    Open(listen);
  } catch (const boost::system::system_error& error) {
    return absl::UnavailableError(
        absl::StrCat("cannot listen on ", listen, ": ", error.code().message(),
                     "; check that the address is correct and the port is free"));
  }
  for (Socket& socket : sockets_) Accept(socket);
  return absl::OkStatus();
}

void TcpAcceptor::Open(const std::string& listen) {
  const size_t colon = listen.rfind(':');
  std::string host = listen.substr(0, colon);
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  const auto entries = tcp::resolver(io_).resolve(host, listen.substr(colon + 1));
  // A name such as localhost may resolve to IPv4 and IPv6 even if the machine supports only one.
  std::set<tcp::endpoint> endpoints;
  for (const auto& entry : entries) endpoints.insert(entry.endpoint());
  error_code problem;
  for (tcp::endpoint endpoint : endpoints) {
    if (endpoint.port() == 0 && !sockets_.empty()) endpoint.port(static_cast<uint16_t>(port()));
    try {
      sockets_.push_back({tcp::acceptor(io_, endpoint), boost::asio::steady_timer(io_)});
    } catch (const boost::system::system_error& error) {
      problem = error.code();
      if (problem == boost::asio::error::address_in_use) throw;
    }
  }
  if (sockets_.empty()) throw boost::system::system_error(problem);
}

void TcpAcceptor::Resume() {
  paused_ = false;
  for (Socket& socket : sockets_) {
    if (std::exchange(socket.waits_for_resume, false)) Accept(socket);
  }
}

void TcpAcceptor::Close() {
  closed_ = true;
  error_code ignored;
  for (Socket& socket : sockets_) {
    socket.acceptor.close(ignored);
    socket.retry.cancel();
  }
}

void TcpAcceptor::Accept(Socket& socket) {
  socket.acceptor.async_accept([this, &socket](error_code error, tcp::socket connection) {
    OnAccepted(socket, error, std::move(connection));
  });
}

void TcpAcceptor::OnAccepted(Socket& socket, error_code error, tcp::socket connection) {
  if (closed_) return;
  if (error) {
    socket.retry.expires_after(retry_);
    return socket.retry.async_wait([this, &socket](error_code ended) {
      if (!ended) Accept(socket);
    });
  }
  on_connection_(std::move(connection));
  socket.waits_for_resume = paused_;
  if (!paused_) Accept(socket);
}

}  // namespace sweepstake::net
