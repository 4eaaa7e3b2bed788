// An HTTP/1.1 listener, whose requests a handler answers.
//
// One thread of its own serves all connections and runs the handler, so that nothing here holds up
// a decision. A request that breaks the protocol or a limit gets a 4xx or 503 that says what is
// valid. The listener outlives a time without free descriptors: it tries again until one is free.
#pragma once

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "server/web/http_message.h"

namespace sweepstake::web {

struct HttpLimits {
  // The maximum number of open connections; the next one waits until one ends.
  size_t max_connections = 2'048;
  // A longer request line with its headers is answered with 431.
  uint32_t max_header_bytes = 8 * 1024;
  // A longer body is answered with 413; one that would have all bodies that are being read or
  // answered exceed the total, with 503.
  size_t max_body_bytes = 256 * 1024;
  size_t max_total_body_bytes = 16 * 1024 * 1024;
  // A connection ends when a request is not complete, an answer not read, or no further request
  // begun after this time. A long answer has a millisecond more for each 16 bytes.
  std::chrono::milliseconds patience{10'000};
  // The time between two attempts to accept while there are no free descriptors.
  std::chrono::milliseconds accept_retry{100};
};

// Makes the handler, which runs on the context's thread and must not wait for others. It ends, and
// all that it owns, before the context, when its thread has ended and each PartSource is gone.
using MakeHandler = std::function<Handler(boost::asio::io_context&)>;

class HttpServer {
 public:
  // `listen` is HOST:PORT; port 0 means any free port. Error: UNAVAILABLE (cannot listen there).
  static absl::StatusOr<std::unique_ptr<HttpServer>> Start(const std::string& listen,
                                                           const MakeHandler& make_handler,
                                                           HttpLimits limits = {});
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
