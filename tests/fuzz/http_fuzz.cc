// One connection of the HTTP listener: what a client sends until it ends its side.
#include <sys/socket.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <memory>
#include <string>
#include <utility>

#include "server/web/health_page.h"
#include "server/web/http_connection.h"
#include "server/web/metrics_page.h"
#include "tests/fuzz/input.h"

namespace sweepstake::web {
namespace {

using fuzz::Require;

// The pages of the daemon.
PageTable Pages() {
  const HealthCheck well{"well", [] { return std::optional<std::string>(); }};
  const HealthCheck ill{"ill", [] { return std::optional<std::string>("it is"); }};
  PageTable pages;
  pages["/livez"] = [=](std::string_view query) { return HealthPage("livez", {well}, query); };
  pages["/readyz"] = [=](std::string_view query) { return HealthPage("readyz", {ill}, query); };
  pages["/metrics"] = [](std::string_view) {
    return MetricsPage({CounterOf("count", "Of something.", 1)});
  };
  return pages;
}

// An answer to each byte would fit the socket's buffer, so that nobody has to read meanwhile.
constexpr size_t kMaxBytes = 4096;

// Returns all that the server answers.
std::string Exchange(std::string_view request) {
  static const PageTable kPages = Pages();
  static const HttpLimits kLimits;
  int ends[2];
  Require(socketpair(AF_UNIX, SOCK_STREAM, 0, ends) == 0, "a connection");
  boost::asio::io_context io{1};
  boost::asio::ip::tcp::socket socket(io);
  socket.assign(boost::asio::ip::tcp::v4(), ends[0]);
  int closed_count = 0;
  std::make_shared<HttpConnection>(std::move(socket), kPages, kLimits, [&] {
    ++closed_count;
  })->Read();
  Require(write(ends[1], request.data(), request.size()) >= 0, "the request is sent");
  shutdown(ends[1], SHUT_WR);
  io.run();
  Require(closed_count == 1, "the connection ends with its client's side");
  std::string answers;
  char bytes[4096];
  for (ssize_t count = 0; (count = read(ends[1], bytes, sizeof bytes)) > 0;)
    answers.append(bytes, static_cast<size_t>(count));
  close(ends[1]);
  return answers;
}

}  // namespace
}  // namespace sweepstake::web

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace sweepstake;
  const std::string_view request(reinterpret_cast<const char*>(data),
                                 std::min(size, web::kMaxBytes));
  const std::string answers = web::Exchange(request);
  fuzz::Require(answers.empty() || answers.starts_with("HTTP/1."), "an answer is HTTP");
  fuzz::Require(answers.find("HTTP/1.1 5") == std::string::npos ||
                    answers.find("HTTP/1.1 503 ") != std::string::npos,
                "no request is the server's error");
  return 0;
}
