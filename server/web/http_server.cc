#include "server/web/http_server.h"

#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/net/tcp_acceptor.h"
#include "server/web/http_connection.h"

namespace sweepstake::web {

// Accepts connections, on a thread of its own from Run on.
class HttpServer::Listener {
 public:
  Listener(PageTable pages, HttpLimits limits)
      : pages_(std::move(pages)),
        limits_(limits),
        acceptor_(io_, limits.accept_retry,
                  [this](auto socket) { OnAccepted(std::move(socket)); }) {}
  ~Listener() {
    io_.stop();
    if (thread_.joinable()) thread_.join();
    ending_ = true;
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
    std::make_shared<HttpConnection>(std::move(socket), pages_, limits_, [this] {
      OnClosed();
    })->Read();
    if (++connection_count_ >= limits_.max_connections) acceptor_.Pause();
  }

  void OnClosed() {
    --connection_count_;
    if (!ending_) acceptor_.Resume();
  }

  const PageTable pages_;
  const HttpLimits limits_;
  size_t connection_count_ = 0;
  bool ending_ = false;
  boost::asio::io_context io_{1};  // its destructor destroys the connections
  net::TcpAcceptor acceptor_;
  std::thread thread_;
};

absl::StatusOr<std::unique_ptr<HttpServer>> HttpServer::Start(const std::string& listen,
                                                              PageTable pages, HttpLimits limits) {
  auto listener = std::make_unique<Listener>(std::move(pages), limits);
  if (absl::Status status = listener->Run(listen); !status.ok())
    return absl::Status(status.code(), absl::StrCat("for HTTP: ", status.message()));
  return std::unique_ptr<HttpServer>(new HttpServer(std::move(listener)));
}

HttpServer::HttpServer(std::unique_ptr<Listener> listener) : listener_(std::move(listener)) {}

HttpServer::~HttpServer() = default;

int HttpServer::port() const { return listener_->port(); }

}  // namespace sweepstake::web
