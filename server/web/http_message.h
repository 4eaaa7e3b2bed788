// A request, its answer, and the ways to answer: at once, later, or in parts that are sent as they
// become available. Used on the thread of the HTTP server only.
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
  std::string peer;      // the remote address in gRPC's format: "ipv4:127.0.0.1:4711"
  std::string own_host;  // the local address as in a URL: "127.0.0.1", "[::1]"
  bool is_tls = false;   // the connection uses TLS
  // The path under which a proxy serves the daemon: "/sweepstake", or empty. It is not part of the
  // target, but links and cookies need it.
  std::string base_path = {};

  std::string_view target() const { return {message.target().data(), message.target().size()}; }
  // Return the part of the target before and after the question mark.
  std::string_view path() const { return target().substr(0, target().find('?')); }
  std::string_view query() const;
  // Returns the header, empty if it is absent.
  std::string_view Header(std::string_view name) const;
  // Returns the last header of this name, empty if there is none.
  std::string_view LastHeader(std::string_view name) const;
  bool is_post() const { return message.method() == boost::beast::http::verb::post; }
};

struct Page {
  int status = 200;
  std::string body = {};
  std::string content_type = "text/plain; charset=utf-8";
  std::vector<std::pair<std::string, std::string>> headers =
      {};  // in addition to the headers of every answer
};

// The type and further headers of an answer in parts.
struct StreamHead {
  std::string content_type;
  std::vector<std::pair<std::string, std::string>> headers = {};
};

// The parts of an answer. The connection owns it, and destroys it when the client has disconnected
// or does not read, or when the answer is complete.
class PartSource {
 public:
  virtual ~PartSource() = default;
  // Called once, before Next. Call `wake` when there may be a new part. `wake` does nothing once
  // this object is destroyed.
  virtual void Start(std::function<void()> wake) = 0;
  // Returns the next part; null if there is none now. Connections may share parts.
  virtual std::shared_ptr<const std::string> Next() = 0;
  // Returns whether the answer is complete.
  virtual bool ended() const = 0;
  // Returns whether the answer cannot be completed. The connection then ends, so that the client
  // notices.
  virtual bool failed() const { return false; }
  // Returns whether only the client ends the answer, as with server-sent events. Such an answer is
  // not compressed, because its parts are shared.
  virtual bool endless() const { return false; }
};

// A request that waits for its answer. Call either Answer or Stream, once. If the last reference is
// released before that, the connection ends.
class Exchange {
 public:
  virtual ~Exchange() = default;
  virtual const Request& request() const = 0;
  virtual void Answer(Page page) = 0;
  // Answers with status 200 and the parts of the source: in chunks, or, for a client with HTTP/1.0,
  // until the end of the connection. If such an answer is not complete, the connection is reset.
  virtual void Stream(StreamHead head, std::unique_ptr<PartSource> source) = 0;
};

using Handler = std::function<void(const std::shared_ptr<Exchange>&)>;

}  // namespace sweepstake::web
