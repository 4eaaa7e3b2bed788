// A request without a connection. It keeps its answer.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/web/http_message.h"

namespace sweepstake::web {

class FakeExchange final : public Exchange {
 public:
  using Headers = std::vector<std::pair<std::string, std::string>>;

  // By default the request comes from this machine, and its Host is a name that every daemon
  // accepts. `headers` and `peer` can change this.
  FakeExchange(boost::beast::http::verb method, const std::string& target,
               const Headers& headers = {}, const std::string& body = "",
               const std::string& peer = "ipv4:127.0.0.1:4711") {
    request_.message = {method, target, 11, body};
    request_.message.set("Host", "localhost");
    for (const auto& [name, value] : headers) request_.message.set(name, value);
    request_.peer = peer;
    request_.own_host = "192.0.2.1";
  }
  // Returns the headers of a request by the daemon's own page, which may send POST requests.
  static Headers OfPage() { return {{"X-Sweepstake", "1"}}; }

  const Request& request() const override { return request_; }
  void Answer(Page page) override { answer_ = std::move(page); }
  void Stream(StreamHead head, std::unique_ptr<PartSource> /*source*/) override {
    answer_ =
        Page{.content_type = std::move(head.content_type), .headers = std::move(head.headers)};
  }
  Request& mutable_request() { return request_; }
  // REQUIRES: the request was answered.
  const Page& answer() const { return answer_.value(); }
  // Returns the value of a header of the answer; empty if it is absent.
  std::string AnswerHeader(const std::string& name) const {
    for (const auto& [header, value] : answer().headers) {
      if (header == name) return value;
    }
    return {};
  }

 private:
  Request request_;
  std::optional<Page> answer_;
};

}  // namespace sweepstake::web
