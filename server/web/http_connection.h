// One connection of the HTTP server. It reads requests one after another and passes each to the
// handler. Pending operations and unanswered requests keep it alive.
#pragma once

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/serializer.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "server/web/gzip.h"
#include "server/web/http_message.h"
#include "server/web/http_server.h"
#include "server/web/http_stream.h"

namespace sweepstake::web {

// The limits, the handler and the counter that all connections of a server share.
struct ConnectionShared {
  const HttpLimits limits;
  Handler handler;
  size_t body_bytes = 0;    // size of the request bodies that are being read or answered
  size_t answer_bytes = 0;  // size of the bodies of answers that are being written
};

class HttpConnection final : public Exchange, public std::enable_shared_from_this<HttpConnection> {
 public:
  // `tls` is null for plain text. `on_closed` runs when the connection is destroyed. `shared` must
  // live until then.
  HttpConnection(boost::asio::ip::tcp::socket socket, std::shared_ptr<tls::TlsContext> tls,
                 ConnectionShared& shared, std::function<void(HttpConnection&)> on_closed);
  ~HttpConnection() override;
  HttpConnection(const HttpConnection&) = delete;
  HttpConnection& operator=(const HttpConnection&) = delete;

  // Makes the handshake, if the connection uses TLS, and reads the first request.
  void Start();
  // Since when the connection waits for a request. Absent: it is answering one.
  std::optional<std::chrono::steady_clock::time_point> idle_since() const { return idle_since_; }
  // The remote address of the connection itself, in gRPC's format.
  std::string peer();
  // Ends the connection at once, also during an answer.
  void Drop();

  const Request& request() const override { return request_; }
  void Answer(Page page) override;
  void Stream(StreamHead head, std::unique_ptr<PartSource> source) override;

 private:
  using Parser = boost::beast::http::request_parser<boost::beast::http::string_body>;
  using Error = boost::system::error_code;

  // Reads the next request.
  void Read();
  void OnHeader(Error error);
  void OnBody(Error error);
  // Returns the error of a request whose header is read; nothing if its body may be read.
  std::optional<Page> HeaderProblem() const;
  void ReserveBody(size_t byte_count);
  void ReserveAnswer(size_t byte_count);
  // Returns the time in which a client must read `byte_count` bytes.
  std::chrono::milliseconds PatienceFor(size_t byte_count) const;
  void Reject(const Page& page);
  void Write(Page page, bool keep_alive);
  void OnWritten(Error error);
  // Reads what the client still sends after the answer. If the connection were closed at once, the
  // client could lose the answer.
  void Linger();

  // Removes the base path from the target of the request.
  void StripBase();

  // The next seven send a stream. A client may close its sending side and receive the rest of the
  // stream. If the stream is endless, that client counts as disconnected, as in nginx and Go's
  // net/http.
  void WriteStreamHead(const StreamHead& head);
  void AwaitEnd();
  void AwaitReset();
  void WriteParts();
  // Returns the source's next part, compressed if the answer is; null if there is none now.
  std::shared_ptr<const std::string> NextPart();
  void OnPartWritten(Error error);
  // Whether the connection is reset when it or the process ends. In HTTP/1.0 the end of the
  // connection is the end of the answer, so a client could not notice that an answer is incomplete.
  void ResetOnClose(bool resets);

  ConnectionShared& shared_;
  const std::function<void(HttpConnection&)> on_closed_;
  HttpStream stream_;
  boost::beast::flat_buffer buffer_;
  std::optional<std::chrono::steady_clock::time_point> idle_since_;
  // The four members below are made again for each request.
  std::optional<Parser> parser_;
  Request request_;
  size_t reserved_bytes_ = 0;
  size_t reserved_answer_bytes_ = 0;
  boost::beast::http::response<boost::beast::http::string_body> response_;
  // The members below are used for a stream.
  boost::beast::http::response<boost::beast::http::empty_body> head_;
  std::optional<boost::beast::http::response_serializer<boost::beast::http::empty_body>>
      serializer_;
  std::unique_ptr<PartSource> source_;
  std::optional<GzipWriter> gzip_;  // absent if the answer is not compressed, or at its end
  std::shared_ptr<const std::string> part_;  // the part that is being written
  bool writing_ = false;
};

}  // namespace sweepstake::web
