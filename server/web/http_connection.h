// One connection of the HTTP server: reads requests one after the other and answers each from the
// table of pages. Used on the server's thread only. Pending operations keep it alive.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/string_body.hpp>
#include <functional>
#include <memory>
#include <optional>

#include "server/web/http_server.h"

namespace sweepstake::web {

class HttpConnection : public std::enable_shared_from_this<HttpConnection> {
 public:
  // `on_closed` runs when the connection is gone. The table and the limits must live until then.
  HttpConnection(boost::asio::ip::tcp::socket socket, const PageTable& pages,
                 const HttpLimits& limits, std::function<void()> on_closed);
  ~HttpConnection() { on_closed_(); }
  HttpConnection(const HttpConnection&) = delete;
  HttpConnection& operator=(const HttpConnection&) = delete;

  // Reads the next request.
  void Read();

 private:
  using Request = boost::beast::http::request<boost::beast::http::empty_body>;

  void OnHeader(boost::system::error_code error);
  Page PageFor(const Request& request) const;
  void Write(Page page, bool keep_alive);
  void OnWritten(boost::system::error_code error);
  // Tells the client that no more comes, and reads what it still sends: closing at once could take
  // the answer away from it.
  void Linger();

  const PageTable& pages_;
  const HttpLimits& limits_;
  const std::function<void()> on_closed_;
  boost::beast::tcp_stream stream_;
  boost::beast::flat_buffer buffer_;
  // These are made anew for each request.
  std::optional<boost::beast::http::request_parser<boost::beast::http::empty_body>> parser_;
  boost::beast::http::response<boost::beast::http::string_body> response_;
};

}  // namespace sweepstake::web
