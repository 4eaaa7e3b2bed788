// Fuzzes one connection of the HTTP listener: all that a client sends until it closes its side.
#include <sys/socket.h>
#include <unistd.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "server/web/api/methods.h"
#include "server/web/error_page.h"
#include "server/web/health_page.h"
#include "server/web/http_connection.h"
#include "server/web/metrics_page.h"
#include "server/web/query.h"
#include "server/web/site.h"
#include "sweepstake/v1/posteriors.pb.h"
#include "tests/fuzz/input.h"

namespace sweepstake::web {
namespace {

using fuzz::Require;

// Returns the pages of the daemon.
PageTable Pages() {
  const HealthCheck well{"well", [] { return std::optional<std::string>(); }};
  const HealthCheck ill{"ill", [] { return std::optional<std::string>("it is"); }};
  PageTable pages;
  pages["/livez"] = [=](std::string_view query) { return HealthPage("livez", {well}, query); };
  pages["/readyz"] = [=](std::string_view query) { return HealthPage("readyz", {ill}, query); };
  pages["/metrics"] = [](std::string_view) {
    return MetricsPage({CounterOf("count", "Counts something.", 1)});
  };
  return pages;
}

// A text that is sent in two parts.
class Halves final : public PartSource {
 public:
  explicit Halves(std::string text) : text_(std::move(text)) {}
  void Start(std::function<void()> wake) override { wake(); }
  std::shared_ptr<const std::string> Next() override {
    if (text_.empty()) return nullptr;
    const size_t size = (text_.size() + 1) / 2;
    auto part = std::make_shared<const std::string>(text_.substr(0, size));
    text_.erase(0, size);
    return part;
  }
  bool ended() const override { return text_.empty(); }

 private:
  std::string text_;
};

// Answers with the request that the API would forward, converted back to JSON.
void Echo(const std::shared_ptr<Exchange>& exchange) {
  static const std::vector<std::string> kNames = {"PosteriorsService/ListPosteriors",
                                                  "PosteriorsService/WatchPosteriors"};
  static const Methods kMethods(kNames);
  v1::ListPosteriorsRequest linked;  // links the descriptors of its file
  const Request& request = exchange->request();
  const Method* method = kMethods.Find(request.path().substr(request.path().find('/', 1) + 1));
  if (method == nullptr) return exchange->Answer({404, linked.DebugString()});
  const auto query = QueryValue(request.query(), "request");
  if (!query.ok()) return exchange->Answer(ErrorPage(query.status()));
  const auto message =
      FromJson(request.is_post() ? request.message.body() : *query, *method->request);
  if (!message.ok()) return exchange->Answer(ErrorPage(message.status()));
  const auto json = ToJson(**message);
  Require(json.ok(), "a request that was read can be written");
  const auto again = FromJson(*json, *method->request);
  Require(again.ok() && Serialize(**again) == Serialize(**message),
          "a written request can be read again");
  if (request.is_post()) return exchange->Answer({.body = *json});
  exchange->Stream({"text/event-stream"}, std::make_unique<Halves>(*json));
}

// The answers to this many bytes fit in the socket's buffer, so that they need not be read in
// between.
constexpr size_t kMaxBytes = 1024;

// Sends the request and returns all answers of the server.
std::string Talk(std::string_view request) {
  static const Site kSite({.pages = Pages(), .hosts = {"a"}, .api = Echo});
  ConnectionShared shared{.limits = {}, .handler = [](const std::shared_ptr<Exchange>& exchange) {
                            kSite.Handle(exchange);
                          }};
  int ends[2];
  Require(socketpair(AF_UNIX, SOCK_STREAM, 0, ends) == 0, "a connection");
  boost::asio::io_context io{1};
  boost::asio::ip::tcp::socket socket(io);
  socket.assign(boost::asio::ip::tcp::v4(), ends[0]);
  int closed_count = 0;
  std::make_shared<HttpConnection>(std::move(socket), /*tls=*/nullptr, shared,
                                   [&](HttpConnection&) { ++closed_count; })
      ->Start();
  Require(write(ends[1], request.data(), request.size()) >= 0, "the request is sent");
  shutdown(ends[1], SHUT_WR);
  io.run();
  Require(closed_count == 1, "the connection ends when its client closes it");
  Require(shared.body_bytes == 0, "no body stays in memory");
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
  const std::string answers = web::Talk(request);
  fuzz::Require(answers.empty() || answers.starts_with("HTTP/1."), "an answer is HTTP");
  // Compares complete lines: a body repeats the request as JSON, which contains no line breaks.
  for (const std::string fault :
       {"500 Internal Server Error", "501 Not Implemented", "504 Gateway Timeout"})
    fuzz::Require(answers.find("HTTP/1.1 " + fault + "\r\n") == std::string::npos,
                  "no request is the server's error");
  return 0;
}
