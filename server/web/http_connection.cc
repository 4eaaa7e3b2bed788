#include "server/web/http_connection.h"

#include <boost/asio/error.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/socket_base.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/http/chunk_encode.hpp>
#include <boost/beast/http/error.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/write.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/net/peer_address.h"

namespace sweepstake::web {
namespace {

namespace http = boost::beast::http;
using boost::asio::ip::tcp;
using boost::system::error_code;

constexpr int kBadRequest = 400;
constexpr int kLengthRequired = 411;
constexpr int kPayloadTooLarge = 413;
constexpr int kHeaderTooLarge = 431;
constexpr int kUnavailable = 503;
constexpr unsigned kHttp11 = 11;
// A client gets additional time for a long answer: 1 ms for every 16 bytes, which is 16 kB/s.
constexpr size_t kBytesPerMs = 16;

// Headers of every answer. The pages run only scripts of this server, and other sites cannot show
// the pages in a frame.
constexpr std::pair<const char*, const char*> kSecurityHeaders[] = {
    {"Content-Security-Policy",
     "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
     "connect-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'"},
    {"X-Frame-Options", "DENY"},
    {"Referrer-Policy", "no-referrer"},
    {"X-Content-Type-Options", "nosniff"},
    {"Cross-Origin-Resource-Policy", "same-origin"},
};

// Sets the headers of every answer, and `more`, which may replace some of them.
template <typename Response, typename Headers>
void SetHeaders(Response& response, const std::string& content_type, const Headers& more) {
  for (const auto& [name, value] : kSecurityHeaders) response.set(name, value);
  response.set(http::field::content_type, content_type);
  response.set(http::field::cache_control, "no-store");
  if (IsCompressible(content_type)) response.set(http::field::vary, "Accept-Encoding");
  for (const auto& [name, value] : more) response.set(name, value);
}

// Returns whether the client violated the protocol. False if the connection only ended.
bool IsMalformed(const error_code& error) {
  return error.category() == http::make_error_code(http::error::bad_method).category() &&
         error != http::error::end_of_stream;
}

Page MalformedPage(const error_code& error) {
  if (error == http::error::header_limit || error == http::error::buffer_overflow)
    return {kHeaderTooLarge, "The request's line and headers are too long.\n"};
  if (error == http::error::body_limit)
    return {kPayloadTooLarge, "The request's body is too long.\n"};
  return {kBadRequest, absl::StrCat("This is not an HTTP/1.1 request: ", error.message(), ".\n")};
}

std::string HostOf(const tcp::socket& socket) {
  error_code unknown;
  const auto address = socket.local_endpoint(unknown).address();
  if (unknown || address.is_v4()) return address.to_string();
  if (address.to_v6().is_v4_mapped())
    return boost::asio::ip::make_address_v4(boost::asio::ip::v4_mapped, address.to_v6())
        .to_string();
  return absl::StrCat("[", address.to_string(), "]");
}

}  // namespace

std::string_view Request::query() const {
  const size_t mark = target().find('?');
  return mark == std::string_view::npos ? std::string_view() : target().substr(mark + 1);
}

std::string_view Request::Header(std::string_view name) const {
  const auto found = message.find(boost::beast::string_view(name.data(), name.size()));
  if (found == message.end()) return {};
  return {found->value().data(), found->value().size()};
}

std::string_view Request::LastHeader(std::string_view name) const {
  const auto [first, last] =
      message.equal_range(boost::beast::string_view(name.data(), name.size()));
  if (first == last) return {};
  const auto value = std::prev(last)->value();
  return {value.data(), value.size()};
}

HttpConnection::HttpConnection(tcp::socket socket, std::shared_ptr<tls::TlsContext> tls,
                               ConnectionShared& shared,
                               std::function<void(HttpConnection&)> on_closed)
    : shared_(shared),
      on_closed_(std::move(on_closed)),
      stream_(std::move(socket), std::move(tls)),
      buffer_(size_t{2} * shared.limits.max_header_bytes) {
  request_.own_host = HostOf(stream_.tcp().socket());
  request_.is_tls = stream_.is_tls();
}

HttpConnection::~HttpConnection() {
  ReserveBody(0);
  ReserveAnswer(0);
  on_closed_(*this);
}

void HttpConnection::Start() {
  idle_since_ = std::chrono::steady_clock::now();
  stream_.tcp().expires_after(shared_.limits.patience);
  stream_.Handshake([self = shared_from_this()](error_code error) {
    if (!error) self->Read();
  });
}

void HttpConnection::Read() {
  idle_since_ = std::chrono::steady_clock::now();
  ReserveBody(0);
  parser_.emplace();
  parser_->header_limit(shared_.limits.max_header_bytes);
  parser_->body_limit(shared_.limits.max_body_bytes);
  // One deadline for the whole request, however slowly its bytes arrive.
  stream_.tcp().expires_after(shared_.limits.patience);
  http::async_read_header(stream_, buffer_, *parser_,
                          [self = shared_from_this()](error_code error, size_t /*byte_count*/) {
                            self->OnHeader(error);
                          });
}

void HttpConnection::OnHeader(error_code error) {
  if (IsMalformed(error)) return Reject(MalformedPage(error));
  if (error) return;
  if (const std::optional<Page> problem = HeaderProblem()) return Reject(*problem);
  ReserveBody(static_cast<size_t>(parser_->content_length().value_or(0)));
  http::async_read(stream_, buffer_, *parser_,
                   [self = shared_from_this()](error_code failure, size_t /*byte_count*/) {
                     self->OnBody(failure);
                   });
}

std::optional<Page> HttpConnection::HeaderProblem() const {
  const auto length = parser_->content_length().value_or(0);
  // Any other encoding must not be ignored: its body would be read as the next request.
  if (parser_->get().count(http::field::transfer_encoding) > 0)
    return Page{kLengthRequired, "A request with a body needs a Content-Length.\n"};
  if (length == 0) return std::nullopt;
  if (parser_->get().method() != http::verb::post)
    return Page{kPayloadTooLarge, "Only a POST request may have a body here.\n"};
  if (shared_.body_bytes + length > shared_.limits.max_total_body_bytes)
    return Page{kUnavailable,
                "The daemon is reading too many large requests at the moment; try again later.\n"};
  return std::nullopt;
}

std::chrono::milliseconds HttpConnection::PatienceFor(size_t byte_count) const {
  return shared_.limits.patience + std::chrono::milliseconds(byte_count / kBytesPerMs);
}

void HttpConnection::ReserveBody(size_t byte_count) {
  shared_.body_bytes += byte_count - std::exchange(reserved_bytes_, byte_count);
}

void HttpConnection::ReserveAnswer(size_t byte_count) {
  shared_.answer_bytes += byte_count - std::exchange(reserved_answer_bytes_, byte_count);
}

void HttpConnection::OnBody(error_code error) {
  if (IsMalformed(error)) return Reject(MalformedPage(error));
  if (error) return;
  idle_since_.reset();
  request_.message = parser_->release();
  request_.peer = peer();
  if (shared_.limits.trusts_proxy)
    request_.peer = net::ForwardedPeer(request_.peer, request_.LastHeader("x-forwarded-for"));
  StripBase();
  shared_.handler(shared_from_this());
}

void HttpConnection::StripBase() {
  request_.base_path = shared_.limits.base_path;
  std::string target(request_.target());
  if (request_.base_path.empty() || !target.starts_with(request_.base_path)) return;
  target.erase(0, request_.base_path.size());
  if (target.empty() || target.front() == '?') target.insert(0, "/");
  if (target.front() == '/') request_.message.target(target);
}

void HttpConnection::Reject(const Page& page) {
  request_.message = {};
  Write(page, /*keep_alive=*/false);
}

void HttpConnection::Answer(Page page) { Write(std::move(page), request_.message.keep_alive()); }

void HttpConnection::Write(Page page, bool keep_alive) {
  response_ = {};
  if (shared_.answer_bytes + page.body.size() > shared_.limits.max_total_answer_bytes)
    page = {kUnavailable,
            "Clients do not read their answers, which take too much memory; try again later.\n"};
  if (AcceptsGzip(request_)) Compress(page);
  page.body.shrink_to_fit();
  ReserveAnswer(page.body.size());
  response_.result(static_cast<unsigned>(page.status));
  SetHeaders(response_, page.content_type, page.headers);
  response_.keep_alive(keep_alive);
  response_.body() = std::move(page.body);
  response_.prepare_payload();
  // The answer to a HEAD has the Content-Length of the answer to a GET, but not its body.
  if (request_.message.method() == http::verb::head) response_.body().clear();
  stream_.tcp().expires_after(PatienceFor(response_.body().size()));
  http::async_write(stream_, response_,
                    [self = shared_from_this()](error_code error, size_t /*byte_count*/) {
                      self->OnWritten(error);
                    });
}

void HttpConnection::OnWritten(error_code error) {
  ReserveAnswer(0);
  response_.body() = {};
  if (error) return;
  if (response_.keep_alive()) return Read();
  stream_.tcp().socket().shutdown(tcp::socket::shutdown_send, error);
  stream_.tcp().expires_after(shared_.limits.patience);
  Linger();
}

void HttpConnection::Linger() {
  buffer_.clear();
  stream_.async_read_some(buffer_.prepare(shared_.limits.max_header_bytes),
                          [self = shared_from_this()](error_code error, size_t /*byte_count*/) {
                            if (!error) self->Linger();
                          });
}

std::string HttpConnection::peer() { return net::PeerOf(stream_.tcp().socket().native_handle()); }

void HttpConnection::Drop() {
  idle_since_.reset();
  source_.reset();
  stream_.tcp().close();
}

void HttpConnection::Stream(StreamHead head, std::unique_ptr<PartSource> source) {
  writing_ = true;
  source_ = std::move(source);
  gzip_.reset();
  if (!source_->endless() && AcceptsGzip(request_) && IsCompressible(head.content_type)) {
    gzip_.emplace();
    head.headers.emplace_back("Content-Encoding", "gzip");
  }
  // Requests the parts later, because the caller of `wake` may still be changing them.
  source_->Start([weak = weak_from_this()] {
    const auto self = weak.lock();
    if (!self || self->writing_) return;
    boost::asio::post(self->stream_.get_executor(), [self] { self->WriteParts(); });
  });
  stream_.tcp().expires_never();
  AwaitEnd();
  WriteStreamHead(head);
}

void HttpConnection::WriteStreamHead(const StreamHead& head) {
  head_ = {};
  head_.version(request_.message.version());
  SetHeaders(head_, head.content_type, head.headers);
  head_.set("X-Accel-Buffering", "no");  // proxies must pass each part on at once
  head_.keep_alive(false);
  head_.chunked(head_.version() >= kHttp11);
  if (!head_.chunked()) ResetOnClose(true);
  serializer_.emplace(head_);
  stream_.tcp().expires_after(shared_.limits.patience);
  http::async_write_header(stream_, *serializer_,
                           [self = shared_from_this()](error_code error, size_t /*byte_count*/) {
                             self->OnPartWritten(error);
                           });
}

void HttpConnection::AwaitEnd() {
  buffer_.clear();
  stream_.async_read_some(buffer_.prepare(shared_.limits.max_header_bytes),
                          [self = shared_from_this()](error_code error, size_t /*byte_count*/) {
                            if (!self->source_) return;
                            if (!error) return self->AwaitEnd();
                            const bool half_closed = error == boost::asio::error::eof;
                            half_closed && !self->source_->endless() ? self->AwaitReset()
                                                                     : self->Drop();
                          });
}

void HttpConnection::AwaitReset() {
  stream_.tcp().socket().async_wait(tcp::socket::wait_error,
                                    [self = shared_from_this()](error_code /*error*/) {
                                      if (self->source_) self->Drop();
                                    });
}

void HttpConnection::WriteParts() {
  if (writing_ || !source_) return;
  const auto on_written = [self = shared_from_this()](error_code error, size_t /*byte_count*/) {
    self->OnPartWritten(error);
  };
  writing_ = true;
  part_ = NextPart();
  if (source_->failed()) return Drop();
  writing_ = part_ != nullptr || source_->ended();
  if (!writing_) return;
  stream_.tcp().expires_after(PatienceFor(part_ ? part_->size() : 0));
  const auto bytes = part_ ? boost::asio::buffer(*part_) : boost::asio::const_buffer();
  if (!part_) source_.reset();
  if (part_ && head_.chunked()) {
    boost::asio::async_write(stream_, http::make_chunk(bytes), on_written);
  } else if (part_) {
    boost::asio::async_write(stream_, bytes, on_written);
  } else if (head_.chunked()) {
    boost::asio::async_write(stream_, http::make_chunk_last(), on_written);
  } else {
    ResetOnClose(false);
    OnPartWritten({});
  }
}

std::shared_ptr<const std::string> HttpConnection::NextPart() {
  std::shared_ptr<const std::string> part = source_->Next();
  if (!gzip_) return part;
  if (part) return std::make_shared<const std::string>(gzip_->Write(*part, /*is_last=*/false));
  if (!source_->ended()) return nullptr;
  part = std::make_shared<const std::string>(gzip_->Write({}, /*is_last=*/true));
  gzip_.reset();
  return part;
}

void HttpConnection::ResetOnClose(bool resets) {
  error_code ignored;
  stream_.tcp().socket().set_option(boost::asio::socket_base::linger(resets, 0), ignored);
}

void HttpConnection::OnPartWritten(error_code error) {
  writing_ = false;
  if (error) return Drop();
  if (source_) return WriteParts();
  // Closing now cannot discard the last part on the client's side, because everything that the
  // client sent has been read.
  stream_.tcp().socket().shutdown(tcp::socket::shutdown_send, error);
  Drop();
}

}  // namespace sweepstake::web
