// A listener for HTTP/1.1 and HTTP/1.0, with TLS or in plain text, whose requests a handler
// answers.
//
// A separate thread serves all connections and runs the handler, so that nothing here delays a
// decision. A request that violates the protocol or a limit is answered with a 4xx or 503 that
// states what is valid. While the process has no free file descriptors, the listener keeps trying
// to accept.
#pragma once

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "engine_client/telemetry/tls/tls_files.h"
#include "server/web/http_message.h"

namespace sweepstake::web {

struct HttpLimits {
  // The maximum number of open connections. The next one replaces the one that has waited longest
  // for a request. If all are answering requests, it waits until one ends.
  size_t max_connections = 2'048;
  // A request whose request line and headers are longer is answered with 431.
  uint32_t max_header_bytes = 8 * 1024;
  // A longer body is answered with 413. A request is answered with 503 if its body would make all
  // bodies that are being read or answered exceed the total.
  size_t max_body_bytes = 256 * 1024;
  size_t max_total_body_bytes = 16 * 1024 * 1024;
  // A request is answered with 503 if the bodies of all answers that clients have not read yet
  // would exceed this.
  size_t max_total_answer_bytes = 128 * 1024 * 1024;
  // A connection ends if after this time a request is not complete, an answer is not read, or no
  // further request has begun. An answer gets one more millisecond for every 16 bytes.
  std::chrono::milliseconds patience{10'000};
  // Whether clients on this machine are a proxy whose header x-forwarded-for names the real client.
  bool trusts_proxy = false;
  // The path under which a proxy serves the daemon: "/sweepstake", or empty. It is removed from the
  // targets of requests that begin with it.
  std::string base_path = {};
  // The time between two attempts to accept while there are no free descriptors.
  std::chrono::milliseconds accept_retry{100};
};

// Makes the handler, which runs on the context's thread and must not block. The handler is
// destroyed before the context, after the context's thread has ended and every PartSource is
// destroyed.
using MakeHandler = std::function<Handler(boost::asio::io_context&)>;

// Called on the server's thread for each idle connection that is closed to make room, with the
// remote address.
using OnDropped = std::function<void(const std::string& peer)>;

class HttpServer {
 public:
  // `listen` is HOST:PORT; port 0 means any free port. With the files of `tls`, all connections use
  // TLS; new ones use the certificate that the files have now. `on_dropped` may be empty. Errors:
  // UNAVAILABLE (cannot listen there), those of tls::Certificate.
  static absl::StatusOr<std::unique_ptr<HttpServer>> Start(const std::string& listen,
                                                           const MakeHandler& make_handler,
                                                           const tls::Files& tls = {},
                                                           HttpLimits limits = {},
                                                           OnDropped on_dropped = {});
  // Drops all connections and ends the thread.
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  int port() const;

 private:
  class Listener;
  explicit HttpServer(std::unique_ptr<Listener> listener);

  std::unique_ptr<Listener> listener_;
};

}  // namespace sweepstake::web
