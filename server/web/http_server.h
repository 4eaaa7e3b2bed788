// An HTTP/1.1 listener with a fixed table of pages, for operators and their programs.
//
// One thread of its own serves all connections and makes the pages, so that nothing here holds up a
// decision. No page is a file, and no path leads to the file system. Only GET and HEAD are known; a
// wrong request gets a 4xx that says what is valid. The listener outlives a time without free
// descriptors: it tries again until one is free.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace sweepstake::web {

struct Page {
  int status = 200;
  std::string body;
  std::string content_type = "text/plain; charset=utf-8";
};

// Makes a page from the request's query, which is what follows the question mark, or empty.
using PageMaker = std::function<Page(std::string_view query)>;

// The makers by path. They run on the server's thread and must not wait for other threads.
using PageTable = std::map<std::string, PageMaker, std::less<>>;

struct HttpLimits {
  // The maximum number of open connections; the next one waits until one ends.
  size_t max_connections = 256;
  // A longer request line with its headers is answered with 431.
  uint32_t max_header_bytes = 8 * 1024;
  // A connection ends when a request is not complete, an answer not read, or no further request
  // begun after this time.
  std::chrono::milliseconds patience{10'000};
  // The time between two attempts to accept while there are no free descriptors.
  std::chrono::milliseconds accept_retry{100};
};

class HttpServer {
 public:
  // `listen` is HOST:PORT; port 0 means any free port. Error: UNAVAILABLE (cannot listen there).
  static absl::StatusOr<std::unique_ptr<HttpServer>> Start(const std::string& listen,
                                                           PageTable pages, HttpLimits limits = {});
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
