// Running calls of the daemon's methods over HTTP. A method with one response is answered with that
// response as JSON. A stream is answered with one JSON message per line, as fast as the client
// reads. An error before the first line sets the HTTP status of the answer; a later error is the
// last line.
//
// The responses can also be answered as CSV. For a method with pages, all pages are read one after
// another, as fast as the client reads. A later error ends the connection, because a file that is
// incomplete must not look complete. Used on the server's thread only.
#pragma once

#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "server/web/api/inbox.h"
#include "server/web/api/methods.h"
#include "server/web/csv/csv_tables.h"
#include "server/web/http_message.h"

namespace sweepstake::web {

// Reports what happened to a response of a stream. The last copy is destroyed when the connection
// has taken the response to send it, with the value true, or when the client has disconnected, with
// the value false.
using Taken = std::shared_ptr<bool>;
using OnResponse =
    std::function<void(const std::shared_ptr<const google::protobuf::Message>&, Taken)>;
using OnEnd = std::function<void(const absl::Status&)>;
// Begins a call. `peer` is the client's address in gRPC's format. Returns false if the method
// cannot be called. The callbacks are called on any thread; `on_end` is called once, last. A stream
// produces its next response after the previous one was taken.
using BeginCall = std::function<bool(
    std::shared_ptr<const google::protobuf::Message> request, const std::string& peer,
    const std::optional<std::string>& token, OnResponse on_response, OnEnd on_end)>;

class Calls {
 public:
  Calls(BeginCall begin, boost::asio::io_context& io)
      : begin_(std::move(begin)), io_(io), inbox_(std::make_shared<Inbox>(io)) {}
  ~Calls() { inbox_->Close(); }
  Calls(const Calls&) = delete;
  Calls& operator=(const Calls&) = delete;

  // Calls the method and answers the exchange, as JSON or, with a table, as CSV. Error: NOT_FOUND
  // (the method has events, which are under /events/).
  void Begin(const Method& method, std::unique_ptr<google::protobuf::Message> request,
             const std::optional<std::string>& token, std::shared_ptr<Exchange> exchange,
             std::unique_ptr<CsvTable> csv = nullptr);

 private:
  struct Answer;
  class Lines;

  // Begins the call of the answer's method, or of its next page.
  void Call(uint64_t number);
  void OnCallResponse(uint64_t number, const google::protobuf::Message& response, Taken taken);
  void OnCallEnd(uint64_t number, const absl::Status& status);
  // Answers with the page and ends the call.
  void Finish(uint64_t number, Page page);
  void ShowLines(uint64_t number);

  const BeginCall begin_;
  boost::asio::io_context& io_;
  const std::shared_ptr<Inbox> inbox_;
  std::map<uint64_t, std::shared_ptr<Answer>> answers_;
  uint64_t last_number_ = 0;
};

}  // namespace sweepstake::web
