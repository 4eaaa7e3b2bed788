#include "server/web/http_server.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/system/system_error.hpp>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/web/http_connection.h"

namespace sweepstake::web {
namespace {

using boost::asio::ip::tcp;
using boost::system::error_code;

// Throws boost::system::system_error. The host of an IPv6 address stands in brackets.
tcp::acceptor Bind(boost::asio::io_context& io, const std::string& listen) {
  const size_t colon = listen.rfind(':');
  std::string host = listen.substr(0, colon);
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  const auto endpoints = tcp::resolver(io).resolve(host, listen.substr(colon + 1));
  return {io, *endpoints.begin()};
}

}  // namespace

// Accepts connections, on a thread of its own from Run on.
class HttpServer::Listener {
 public:
  Listener(const std::string& listen, PageTable pages, HttpLimits limits)
      : pages_(std::move(pages)), limits_(limits), acceptor_(Bind(io_, listen)), retry_(io_) {
    Accept();
    thread_ = std::thread([this] { io_.run(); });
  }
  ~Listener() {
    io_.stop();
    thread_.join();
    ending_ = true;
  }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  int port() const { return acceptor_.local_endpoint().port(); }

 private:
  void Accept() {
    acceptor_.async_accept(
        [this](error_code error, tcp::socket socket) { OnAccepted(error, std::move(socket)); });
  }

  void OnAccepted(error_code error, tcp::socket socket) {
    if (error) return AcceptLater();
    std::make_shared<HttpConnection>(std::move(socket), pages_, limits_, [this] {
      OnClosed();
    })->Read();
    full_ = ++connection_count_ >= limits_.max_connections;
    if (!full_) Accept();
  }

  // Descriptors or memory are short; whoever waits stays in the system's queue.
  void AcceptLater() {
    retry_.expires_after(limits_.accept_retry);
    retry_.async_wait([this](error_code error) {
      if (!error) Accept();
    });
  }

  void OnClosed() {
    --connection_count_;
    if (std::exchange(full_, false) && !ending_) Accept();
  }

  const PageTable pages_;
  const HttpLimits limits_;
  size_t connection_count_ = 0;
  bool full_ = false;  // nothing is accepted until a connection ends
  bool ending_ = false;
  boost::asio::io_context io_{1};  // its destructor destroys the connections
  tcp::acceptor acceptor_;
  boost::asio::steady_timer retry_;
  std::thread thread_;
};

absl::StatusOr<std::unique_ptr<HttpServer>> HttpServer::Start(const std::string& listen,
                                                              PageTable pages, HttpLimits limits) {
  try {
    auto listener = std::make_unique<Listener>(listen, std::move(pages), limits);
    return std::unique_ptr<HttpServer>(new HttpServer(std::move(listener)));
  } catch (const boost::system::system_error& error) {
    return absl::UnavailableError(absl::StrCat("cannot listen on ", listen,
                                               " for HTTP: ", error.code().message(),
                                               "; is the address right, and its port free?"));
  }
}

HttpServer::HttpServer(std::unique_ptr<Listener> listener) : listener_(std::move(listener)) {}

HttpServer::~HttpServer() = default;

int HttpServer::port() const { return listener_->port(); }

}  // namespace sweepstake::web
