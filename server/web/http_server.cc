#include "server/web/http_server.h"

#include <set>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/net/tcp_acceptor.h"
#include "server/web/http_connection.h"

namespace sweepstake::web {

// Accepts connections. Run starts the thread that serves them.
class HttpServer::Listener {
 public:
  Listener(const MakeHandler& make_handler, HttpLimits limits)
      : shared_{.limits = limits, .handler = {}},
        acceptor_(io_, limits.accept_retry,
                  [this](auto socket) { OnAccepted(std::move(socket)); }) {
    shared_.handler = make_handler(io_);
  }
  ~Listener() {
    io_.stop();
    if (thread_.joinable()) thread_.join();
    ending_ = true;
    // Destroys the connections' streams first, because they use objects of the handler. Destroys
    // the handler next, because it uses io_.
    for (HttpConnection* connection : connections_) connection->Drop();
    shared_.handler = {};
  }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  absl::Status Run(const std::string& listen) {
    if (absl::Status status = acceptor_.Listen(listen); !status.ok()) return status;
    thread_ = std::thread([this] { io_.run(); });
    return absl::OkStatus();
  }
  int port() const { return acceptor_.port(); }

 private:
  void OnAccepted(boost::asio::ip::tcp::socket socket) {
    const auto connection = std::make_shared<HttpConnection>(
        std::move(socket), shared_, [this](HttpConnection& closed) { OnClosed(closed); });
    connections_.insert(connection.get());
    connection->Read();
    if (connections_.size() >= shared_.limits.max_connections) acceptor_.Pause();
  }

  void OnClosed(HttpConnection& connection) {
    connections_.erase(&connection);
    if (!ending_) acceptor_.Resume();
  }

  std::set<HttpConnection*> connections_;
  bool ending_ = false;
  ConnectionShared shared_;
  boost::asio::io_context io_{1};  // its destructor destroys the connections
  net::TcpAcceptor acceptor_;
  std::thread thread_;
};

absl::StatusOr<std::unique_ptr<HttpServer>> HttpServer::Start(const std::string& listen,
                                                              const MakeHandler& make_handler,
                                                              HttpLimits limits) {
  auto listener = std::make_unique<Listener>(make_handler, limits);
  if (absl::Status status = listener->Run(listen); !status.ok())
    return absl::Status(status.code(), absl::StrCat("for HTTP: ", status.message()));
  return std::unique_ptr<HttpServer>(new HttpServer(std::move(listener)));
}

HttpServer::HttpServer(std::unique_ptr<Listener> listener) : listener_(std::move(listener)) {}

HttpServer::~HttpServer() = default;

int HttpServer::port() const { return listener_->port(); }

}  // namespace sweepstake::web
