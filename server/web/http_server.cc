#include "server/web/http_server.h"

#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <deque>
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
  Listener(const MakeHandler& make_handler, const tls::Files& tls, HttpLimits limits,
           OnDropped on_dropped)
      : on_dropped_(std::move(on_dropped)),
        shared_{.limits = std::move(limits), .handler = {}},
        certificate_(tls, tls::Protocol::kHttp1),
        acceptor_(io_, shared_.limits.accept_retry,
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
    if (absl::Status status = certificate_.Read(); !status.ok()) return status;
    if (absl::Status status = acceptor_.Listen(listen); !status.ok()) return status;
    ReadCertificate();
    thread_ = std::thread([this] { io_.run(); });
    return absl::OkStatus();
  }
  int port() const { return acceptor_.port(); }

 private:
  // Runs once per second.
  void ReadCertificate() {
    certificate_.Read().IgnoreError();  // the daemon's FilesWatch reports it
    second_.expires_after(std::chrono::seconds(1));
    second_.async_wait([this](const boost::system::error_code& error) {
      if (!error) ReadCertificate();
    });
  }

  void OnAccepted(boost::asio::ip::tcp::socket socket) {
    if (connections_.size() < shared_.limits.max_connections || DropIdle())
      return Begin(std::move(socket));
    waiting_.push_back(std::move(socket));
    acceptor_.Pause();
  }

  void Begin(boost::asio::ip::tcp::socket socket) {
    const auto connection =
        std::make_shared<HttpConnection>(std::move(socket), certificate_.context(), shared_,
                                         [this](HttpConnection& closed) { OnClosed(closed); });
    connections_.insert(connection.get());
    connection->Start();
  }

  // Drops the connection that has waited longest for a request. Returns false if there is none.
  bool DropIdle() {
    HttpConnection* oldest = nullptr;
    for (HttpConnection* each : connections_) {
      if (!each->idle_since()) continue;
      if (oldest == nullptr || *each->idle_since() < *oldest->idle_since()) oldest = each;
    }
    if (oldest == nullptr) return false;
    if (on_dropped_) on_dropped_(oldest->peer());
    oldest->Drop();
    return true;
  }

  void OnClosed(HttpConnection& connection) {
    connections_.erase(&connection);
    if (ending_ || connections_.size() >= shared_.limits.max_connections) return;
    if (waiting_.empty()) return acceptor_.Resume();
    boost::asio::post(
        io_, [this, socket = std::move(waiting_.front())]() mutable { Begin(std::move(socket)); });
    waiting_.pop_front();
  }

  const OnDropped on_dropped_;
  std::set<HttpConnection*> connections_;
  bool ending_ = false;
  ConnectionShared shared_;
  boost::asio::io_context io_{1};                     // its destructor destroys the connections
  std::deque<boost::asio::ip::tcp::socket> waiting_;  // accepted while all places are taken
  tls::Certificate certificate_;
  boost::asio::steady_timer second_{io_};
  net::TcpAcceptor acceptor_;
  std::thread thread_;
};

absl::StatusOr<std::unique_ptr<HttpServer>> HttpServer::Start(const std::string& listen,
                                                              const MakeHandler& make_handler,
                                                              const tls::Files& tls,
                                                              HttpLimits limits,
                                                              OnDropped on_dropped) {
  auto listener =
      std::make_unique<Listener>(make_handler, tls, std::move(limits), std::move(on_dropped));
  if (absl::Status status = listener->Run(listen); !status.ok())
    return absl::Status(status.code(), absl::StrCat("for HTTP: ", status.message()));
  return std::unique_ptr<HttpServer>(new HttpServer(std::move(listener)));
}

HttpServer::HttpServer(std::unique_ptr<Listener> listener) : listener_(std::move(listener)) {}

HttpServer::~HttpServer() = default;

int HttpServer::port() const { return listener_->port(); }

}  // namespace sweepstake::web
