// A request, its answer, and how a request is answered: at once, later, or in parts for as long as
// there is something to say. All of it is used on the thread of the HTTP server only.
#pragma once

#include <boost/beast/http/message.hpp>
#include <boost/beast/http/string_body.hpp>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace sweepstake::web {

struct Request {
  boost::beast::http::request<boost::beast::http::string_body> message;
  std::string peer;      // the other end, as gRPC names one: "ipv4:127.0.0.1:4711"
  std::string own_host;  // the address of this end, as in a URL: "127.0.0.1", "[::1]"

  std::string_view target() const { return {message.target().data(), message.target().size()}; }
  // The target before and after the question mark.
  std::string_view path() const { return target().substr(0, target().find('?')); }
  std::string_view query() const;
  // Returns the header, empty if it is absent.
  std::string_view Header(std::string_view name) const;
  bool is_post() const { return message.method() == boost::beast::http::verb::post; }
};

struct Page {
  int status = 200;
  std::string body = {};
  std::string content_type = "text/plain; charset=utf-8";
  std::vector<std::pair<std::string, std::string>> headers = {};  // beside those of every answer
};

// The parts of an answer. Its connection owns it and destroys it when the client has gone or does
// not read, or the answer is whole.
class PartSource {
 public:
  virtual ~PartSource() = default;
  // Called once, before Next. `wake` is to be called when there may be something new; it does
  // nothing once this object is gone.
  virtual void Start(std::function<void()> wake) = 0;
  // Returns the next part; null if there is none now. Parts may be shared among connections.
  virtual std::shared_ptr<const std::string> Next() = 0;
  // Returns whether no part comes any more.
  virtual bool ended() const = 0;
};

// A request that waits for its answer. One of the two is called, once; a request that nobody holds
// any more and that is not answered ends its connection.
class Exchange {
 public:
  virtual ~Exchange() = default;
  virtual const Request& request() const = 0;
  virtual void Answer(Page page) = 0;
  // Answers with status 200 and what the source has. Only HTTP/1.1 knows such answers: another
  // client gets a 505.
  virtual void Stream(std::string content_type, std::unique_ptr<PartSource> source) = 0;
};

using Handler = std::function<void(const std::shared_ptr<Exchange>&)>;

}  // namespace sweepstake::web
