#include "server/web/http_connection.h"

#include <boost/beast/http/error.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/write.hpp>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"

namespace sweepstake::web {
namespace {

namespace http = boost::beast::http;
using boost::system::error_code;

constexpr int kBadRequest = 400;
constexpr int kNotFound = 404;
constexpr int kMethodNotAllowed = 405;
constexpr int kPayloadTooLarge = 413;
constexpr int kHeaderTooLarge = 431;

// Returns whether the client broke the protocol, as opposed to a connection that ended.
bool IsMalformed(const error_code& error) {
  return error.category() == http::make_error_code(http::error::bad_method).category() &&
         error != http::error::end_of_stream;
}

Page MalformedPage(const error_code& error) {
  if (error == http::error::header_limit || error == http::error::buffer_overflow)
    return {kHeaderTooLarge, "The request's line and headers are too long.\n"};
  return {kBadRequest, absl::StrCat("This is no HTTP/1.1 request: ", error.message(), ".\n")};
}

Page NotFoundPage(const PageTable& pages) {
  const auto append_path = [](std::string* out, const auto& entry) { *out += entry.first; };
  return {kNotFound, absl::StrCat("There is no such page. There are ",
                                  absl::StrJoin(pages, ", ", append_path), ".\n")};
}

}  // namespace

HttpConnection::HttpConnection(boost::asio::ip::tcp::socket socket, const PageTable& pages,
                               const HttpLimits& limits, std::function<void()> on_closed)
    : pages_(pages),
      limits_(limits),
      on_closed_(std::move(on_closed)),
      stream_(std::move(socket)),
      buffer_(size_t{2} * limits.max_header_bytes) {}

void HttpConnection::Read() {
  parser_.emplace();
  parser_->header_limit(limits_.max_header_bytes);
  // One deadline for the whole header, however slowly its bytes come.
  stream_.expires_after(limits_.patience);
  http::async_read_header(stream_, buffer_, *parser_,
                          [self = shared_from_this()](error_code error, size_t /*byte_count*/) {
                            self->OnHeader(error);
                          });
}

void HttpConnection::OnHeader(error_code error) {
  if (IsMalformed(error)) return Write(MalformedPage(error), /*keep_alive=*/false);
  if (error) return;
  if (parser_->content_length().value_or(0) > 0 || parser_->chunked()) {
    return Write({kPayloadTooLarge, "A request here has no body.\n"}, /*keep_alive=*/false);
  }
  const Request& request = parser_->get();
  Write(PageFor(request), request.keep_alive());
}

Page HttpConnection::PageFor(const Request& request) const {
  if (request.method() != http::verb::get && request.method() != http::verb::head)
    return {kMethodNotAllowed, "Only GET and HEAD are valid here.\n"};
  const std::string_view target(request.target().data(), request.target().size());
  if (!target.starts_with('/')) return {kBadRequest, "A request's target begins with a slash.\n"};
  const size_t mark = std::min(target.find('?'), target.size());
  const auto found = pages_.find(target.substr(0, mark));
  if (found == pages_.end()) return NotFoundPage(pages_);
  return found->second(target.substr(std::min(mark + 1, target.size())));
}

void HttpConnection::Write(Page page, bool keep_alive) {
  const Request& request = parser_->get();
  response_ = {};
  response_.result(static_cast<unsigned>(page.status));
  response_.set(http::field::content_type, page.content_type);
  response_.set(http::field::cache_control, "no-store");
  response_.set("X-Content-Type-Options", "nosniff");
  if (page.status == kMethodNotAllowed) response_.set(http::field::allow, "GET, HEAD");
  response_.keep_alive(keep_alive);
  response_.body() = std::move(page.body);
  response_.prepare_payload();
  // The length of what a GET would get stays.
  if (request.method() == http::verb::head) response_.body().clear();
  stream_.expires_after(limits_.patience);
  http::async_write(stream_, response_,
                    [self = shared_from_this()](error_code error, size_t /*byte_count*/) {
                      self->OnWritten(error);
                    });
}

void HttpConnection::OnWritten(error_code error) {
  if (error) return;
  if (response_.keep_alive()) return Read();
  stream_.socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, error);
  stream_.expires_after(limits_.patience);
  Linger();
}

void HttpConnection::Linger() {
  buffer_.clear();
  stream_.async_read_some(buffer_.prepare(limits_.max_header_bytes),
                          [self = shared_from_this()](error_code error, size_t /*byte_count*/) {
                            if (!error) self->Linger();
                          });
}

}  // namespace sweepstake::web
