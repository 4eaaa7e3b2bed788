// Tests the HTTP listener over real sockets: answers, invalid requests and limits.
#include "server/web/http_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/post.hpp>

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/host/no_descriptors.h"
#include "tests/server/web/gunzip.h"
#include "tests/support/http_exchange.h"

namespace sweepstake::web {
namespace {

using test_support::Dechunked;
using test_support::Get;
using test_support::HttpAnswer;
using test_support::HttpSocket;
using test_support::NoDescriptors;
using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

constexpr HttpLimits kPatient = {.patience = std::chrono::minutes(10)};

// Answers with the text of the request. The target /later delays the answer, and /parts sends it in
// parts. /held sends the parts after a request of /release.
class Echo {
 public:
  explicit Echo(boost::asio::io_context& io) : io_(io) {}

  void Handle(const std::shared_ptr<Exchange>& exchange) const {
    const Request& request = exchange->request();
    Page page{.body = std::string(request.query()) + request.message.body() + "\n"};
    if (request.path() == "/drop") return;
    if (request.path() == "/parts")
      return exchange->Stream({"text/x"}, std::make_unique<Parts>(std::string(request.query())));
    if (request.path() == "/held")
      return exchange->Stream({"text/x"},
                              std::make_unique<Parts>(std::string(request.query()), gate_));
    if (request.path() == "/failing")
      return exchange->Stream({"text/x"}, std::make_unique<Failing>());
    if (request.path() == "/release") gate_->Open();
    if (request.path() == "/broken") page = {503, "broken\n", "text/x", {{"X-More", "yes"}}};
    if (request.path() == "/later") return boost::asio::post(io_, [=] { exchange->Answer(page); });
    exchange->Answer(std::move(page));
  }

 private:
  // Holds parts back until it is open.
  struct Gate {
    bool open = false;
    std::function<void()> wake;
    void Open() {
      open = true;
      wake();
    }
  };

  // Sends each character of a text as a part. Without a text it sends no parts and never ends.
  class Parts final : public PartSource {
   public:
    explicit Parts(std::string text, std::shared_ptr<Gate> gate = nullptr)
        : text_(std::move(text)), endless_(text_.empty()), gate_(std::move(gate)) {}
    void Start(std::function<void()> wake) override {
      if (gate_) {
        gate_->wake = std::move(wake);
      } else {
        wake();
      }
    }
    std::shared_ptr<const std::string> Next() override {
      if (text_.empty() || (gate_ && !gate_->open)) return nullptr;
      auto part = std::make_shared<const std::string>(text_.substr(0, 1));
      text_.erase(0, 1);
      return part;
    }
    bool ended() const override { return text_.empty() && !endless_; }
    bool endless() const override { return endless_; }

   private:
    std::string text_;
    const bool endless_;
    const std::shared_ptr<Gate> gate_;
  };

  // Sends one part, and cannot complete the answer.
  class Failing final : public PartSource {
   public:
    void Start(std::function<void()> wake) override { wake(); }
    std::shared_ptr<const std::string> Next() override { return std::exchange(part_, nullptr); }
    bool ended() const override { return false; }
    bool failed() const override { return part_ == nullptr && std::exchange(was_sent_, true); }

   private:
    std::shared_ptr<const std::string> part_ = std::make_shared<const std::string>("a");
    mutable bool was_sent_ = false;
  };

  boost::asio::io_context& io_;
  const std::shared_ptr<Gate> gate_ = std::make_shared<Gate>();
};

Handler MakeEcho(boost::asio::io_context& io) {
  return [echo = std::make_shared<Echo>(io)](const auto& exchange) { echo->Handle(exchange); };
}

std::unique_ptr<HttpServer> StartServer(HttpLimits limits = kPatient, OnDropped on_dropped = {}) {
  auto server = HttpServer::Start("127.0.0.1:0", MakeEcho, /*tls=*/{}, std::move(limits),
                                  std::move(on_dropped));
  EXPECT_TRUE(server.ok()) << server.status();
  return *std::move(server);
}

std::string PostOf(const std::string& body, const std::string& path = "/hello") {
  return "POST " + path +
         " HTTP/1.1\r\nConnection: close\r\nContent-Length: " + std::to_string(body.size()) +
         "\r\n\r\n" + body;
}

TEST(HttpServerTest, AnAnswerHasItsStatusTypeAndHeaders) {
  const auto server = StartServer();
  const HttpAnswer answer = Get(server->port(), "/broken");
  EXPECT_EQ(answer.status, 503);
  EXPECT_EQ(answer.body, "broken\n");
  EXPECT_THAT(answer.head,
              AllOf(HasSubstr("Content-Type: text/x\r\n"), HasSubstr("X-More: yes\r\n"),
                    HasSubstr("Cache-Control: no-store\r\n")));
}

TEST(HttpServerTest, EveryAnswerForbidsFeaturesThatThePagesDoNotNeed) {
  const auto server = StartServer();
  for (const HttpAnswer& answer : {Get(server->port(), "/hello"), Get(server->port(), "/broken"),
                                   Get(server->port(), "/parts?a"),
                                   test_support::Exchange(server->port(), "no request\r\n\r\n")}) {
    EXPECT_THAT(answer.head,
                AllOf(HasSubstr("Content-Security-Policy: default-src 'none'; script-src 'self'; "),
                      HasSubstr("frame-ancestors 'none'"), HasSubstr("X-Frame-Options: DENY\r\n"),
                      HasSubstr("Referrer-Policy: no-referrer\r\n"),
                      HasSubstr("X-Content-Type-Options: nosniff\r\n")));
    EXPECT_THAT(answer.head, Not(HasSubstr("Access-Control")));
  }
}

TEST(HttpServerTest, AnAnswerMayComeLater) {
  const auto server = StartServer();
  EXPECT_EQ(Get(server->port(), "/later?you").body, "you\n");
  EXPECT_EQ(test_support::Exchange(server->port(), PostOf("me", "/later")).body, "me\n");
}

TEST(HttpServerTest, ARequestWithoutAnAnswerEndsItsConnection) {
  const auto server = StartServer();
  EXPECT_EQ(Get(server->port(), "/drop").status, 0);
  EXPECT_EQ(Get(server->port(), "/hello").status, 200);
}

TEST(HttpServerTest, AnAnswerInPartsIsChunkedAndEnds) {
  const auto server = StartServer();
  const HttpAnswer answer = Get(server->port(), "/parts?ab");
  EXPECT_EQ(answer.status, 200);
  EXPECT_THAT(answer.head,
              AllOf(HasSubstr("Transfer-Encoding: chunked\r\n"),
                    HasSubstr("Content-Type: text/x\r\n"), HasSubstr("Connection: close\r\n")));
  EXPECT_EQ(answer.body, "1\r\na\r\n1\r\nb\r\n0\r\n\r\n");
}

TEST(HttpServerTest, AnAnswerThatFailsIsNotCompleted) {
  const auto server = StartServer();
  EXPECT_EQ(Get(server->port(), "/failing").body, "1\r\na\r\n");
  EXPECT_EQ(Get(server->port(), "/hello").status, 200);
}

TEST(HttpServerTest, AnswersAreCompressedForClientsThatAcceptIt) {
  const auto server = StartServer();
  const auto get = [&](const std::string& method, const std::string& target) {
    return test_support::Exchange(
        server->port(),
        method + " " + target + " HTTP/1.1\r\nAccept-Encoding: gzip\r\nConnection: close\r\n\r\n");
  };
  const std::string text(2'000, 'a');
  const HttpAnswer answer = get("GET", "/hello?" + text);
  EXPECT_THAT(answer.head, AllOf(HasSubstr("Content-Encoding: gzip\r\n"),
                                 HasSubstr("Vary: Accept-Encoding\r\n")));
  EXPECT_LT(answer.body.size(), 100u);
  EXPECT_EQ(test_support::Gunzip(answer.body), text + "\n");
  const HttpAnswer head = get("HEAD", "/hello?" + text);
  EXPECT_EQ(head.body, "");
  EXPECT_THAT(head.head,
              HasSubstr("Content-Length: " + std::to_string(answer.body.size()) + "\r\n"));
  EXPECT_THAT(Get(server->port(), "/hello?" + text).head,
              AllOf(Not(HasSubstr("Content-Encoding")), HasSubstr("Vary: Accept-Encoding\r\n")));
  const HttpAnswer parts = get("GET", "/parts?abc");
  EXPECT_THAT(parts.head, HasSubstr("Content-Encoding: gzip\r\n"));
  EXPECT_THAT(parts.body, EndsWith("\r\n0\r\n\r\n"));
  EXPECT_EQ(test_support::Gunzip(Dechunked(parts.body)), "abc");
}

TEST(HttpServerTest, AnEndlessAnswerIsNotCompressed) {
  const auto server = StartServer();
  HttpSocket endless(server->port());
  endless.Send("GET /parts HTTP/1.1\r\nAccept-Encoding: gzip\r\n\r\n");
  EXPECT_THAT(endless.ReadUntil("\r\n\r\n"), Not(HasSubstr("Content-Encoding")));
}

TEST(HttpServerTest, AnAnswerInPartsToHttp10EndsWithItsConnection) {
  const auto server = StartServer();
  const HttpAnswer answer =
      test_support::Exchange(server->port(), "GET /parts?ab HTTP/1.0\r\n\r\n");
  EXPECT_EQ(answer.status, 200);
  EXPECT_THAT(answer.head, AllOf(HasSubstr("HTTP/1.0 200 OK\r\n"), Not(HasSubstr("chunked")),
                                 Not(HasSubstr("keep-alive"))));
  EXPECT_EQ(answer.body, "ab");
}

TEST(HttpServerTest, AnIncompleteAnswerToHttp10EndsWithAReset) {
  auto server = StartServer();
  HttpSocket endless(server->port());
  endless.Send("GET /parts HTTP/1.0\r\n\r\n");
  EXPECT_THAT(endless.ReadUntil("\r\n\r\n"), HasSubstr("200 OK"));
  server.reset();
  EXPECT_TRUE(endless.WasReset());
}

TEST(HttpServerTest, TheBasePathIsNotPartOfTheTarget) {
  const auto server = StartServer({.base_path = "/tools/sweepstake"});
  for (const char* target : {"/tools/sweepstake/hello?you", "/tools/sweepstake?you", "/hello?you"})
    EXPECT_EQ(Get(server->port(), target).body, "you\n") << target;
  EXPECT_EQ(Get(server->port(), "/tools/sweepstake/parts?a").body, "1\r\na\r\n0\r\n\r\n");
  EXPECT_EQ(Get(server->port(), "/tools/sweepstakes/parts?a").body, "a\n") << "another path";
}

TEST(HttpServerTest, AnAnswerInPartsWaitsForPartsAndEndsWithItsClient) {
  const auto server = StartServer({.max_connections = 1, .patience = std::chrono::seconds(1)});
  {
    HttpSocket endless(server->port());
    endless.Send("GET /parts HTTP/1.1\r\n\r\n");
    EXPECT_THAT(endless.ReadUntil("\r\n\r\n"), HasSubstr("200 OK"));
    std::this_thread::sleep_for(std::chrono::milliseconds(1'500));
    endless.Send("this is not a request");
  }
  EXPECT_EQ(Get(server->port(), "/hello?next").body, "next\n") << "the only connection is free";
}

TEST(HttpServerTest, AHalfClosedClientGetsAllPartsUnlessTheyAreEndless) {
  const auto server = StartServer();
  HttpSocket client(server->port());
  HttpSocket endless(server->port());
  client.Send("GET /held?ab HTTP/1.1\r\n\r\n");
  endless.Send("GET /parts HTTP/1.1\r\n\r\n");
  for (HttpSocket* socket : {&client, &endless}) {
    EXPECT_THAT(socket->ReadUntil("\r\n\r\n"), HasSubstr("200 OK"));
    socket->HalfClose();
  }
  EXPECT_EQ(endless.ReadAll(), "");
  Get(server->port(), "/release");
  EXPECT_EQ(client.ReadAll(), "1\r\na\r\n1\r\nb\r\n0\r\n\r\n");
}

TEST(HttpServerTest, AResetOfAHalfClosedClientEndsItsAnswerInParts) {
  const auto server = StartServer({.max_connections = 1, .patience = kPatient.patience});
  HttpSocket client(server->port());
  client.Send("GET /held?ab HTTP/1.1\r\n\r\n");
  EXPECT_THAT(client.ReadUntil("\r\n\r\n"), HasSubstr("200 OK"));
  client.HalfClose();
  // This is long enough on most machines for the server to read the half-close.
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  client.Reset();
  EXPECT_EQ(Get(server->port(), "/hello?next").body, "next\n") << "the only connection is free";
}

TEST(HttpServerTest, ABodyComesWhole) {
  const auto server = StartServer();
  EXPECT_EQ(test_support::Exchange(server->port(), PostOf("abc")).body, "abc\n");
  EXPECT_EQ(test_support::Exchange(server->port(), PostOf("")).body, "\n");
  const std::string longest(HttpLimits().max_body_bytes, 'a');
  EXPECT_EQ(test_support::Exchange(server->port(), PostOf(longest)).body, longest + "\n");
}

TEST(HttpServerTest, AHeadHasTheLengthAndNoBody) {
  const auto server = StartServer();
  const HttpAnswer answer =
      test_support::Exchange(server->port(), "HEAD /hello HTTP/1.1\r\nConnection: close\r\n\r\n");
  EXPECT_EQ(answer.status, 200);
  EXPECT_THAT(answer.head, HasSubstr("Content-Length: 1\r\n"));
  EXPECT_EQ(answer.body, "");
}

TEST(HttpServerTest, AConnectionServesManyRequestsEvenIfAllAreSentAtOnce) {
  const auto server = StartServer();
  HttpSocket socket(server->port());
  socket.Send("GET /hello?1 HTTP/1.1\r\n\r\nGET /hello?2 HTTP/1.1\r\n\r\n");
  EXPECT_THAT(socket.ReadAnswer(), EndsWith("\n1\n"));
  EXPECT_THAT(socket.ReadAnswer(), EndsWith("\n2\n"));
  socket.Send("GET /hello?3 HTTP/1.1\r\n\r\n");
  EXPECT_THAT(socket.ReadAnswer(), EndsWith("\n3\n"));
}

TEST(HttpServerTest, AnInvalidRequestIsAnsweredAndTheConnectionEnds) {
  const auto server = StartServer();
  for (const std::string request :
       {"hello\r\n\r\n", "GET\r\n\r\n", "GET /hello HTTP/9.9\r\n\r\n", "GET /hello\r\n\r\n",
        "\x16\x03\x01\x02 a TLS handshake\r\n\r\n", "GET /hello HTTP/1.1\r\nno colon\r\n\r\n",
        "POST /hello HTTP/1.1\r\nContent-Length: 1\r\nContent-Length: 2\r\n\r\nab",
        "POST /hello HTTP/1.1\r\nContent-Length: -1\r\n\r\n"}) {
    const HttpAnswer answer = test_support::Exchange(server->port(), request);
    EXPECT_EQ(answer.status, 400) << request;
    EXPECT_THAT(answer.head, HasSubstr("Connection: close\r\n")) << request;
  }
  EXPECT_EQ(Get(server->port(), "/hello").status, 200);
}

TEST(HttpServerTest, AnUnexpectedOrTooLongBodyIsRefused) {
  const auto server = StartServer();
  EXPECT_EQ(
      test_support::Exchange(server->port(), "GET /hello HTTP/1.1\r\nContent-Length: 3\r\n\r\nabc")
          .status,
      413);
  EXPECT_EQ(test_support::Exchange(server->port(),
                                   PostOf(std::string(HttpLimits().max_body_bytes + 1, 'a')))
                .status,
            413);
  EXPECT_EQ(
      test_support::Exchange(
          server->port(), "POST /hello HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n3\r\nabc\r\n")
          .status,
      411);
  for (const char* coding : {"gzip", "identity", "chunked, identity", "xchunked"}) {
    const HttpAnswer answer = test_support::Exchange(
        server->port(), std::string("POST /hello HTTP/1.1\r\nTransfer-Encoding: ") + coding +
                            "\r\n\r\nGET /hello?smuggled HTTP/1.1\r\n\r\n");
    EXPECT_EQ(answer.status, 411) << coding;
    EXPECT_THAT(answer.body, Not(HasSubstr("smuggled"))) << coding;
  }
}

TEST(HttpServerTest, AllBodiesTogetherAreBounded) {
  const auto server = StartServer({.max_total_body_bytes = 10, .patience = kPatient.patience});
  {
    HttpSocket slow(server->port());
    slow.Send("POST /hello HTTP/1.1\r\nContent-Length: 8\r\n\r\nabcdefg");
    // Waits until the server has read the headers of the first request.
    while (test_support::Exchange(server->port(), PostOf("abc")).status != 503)
      std::this_thread::yield();
    EXPECT_EQ(test_support::Exchange(server->port(), PostOf("ab")).status, 200);
    slow.Send("h");
    EXPECT_THAT(slow.ReadAnswer(), EndsWith("abcdefgh\n"));
  }
  while (test_support::Exchange(server->port(), PostOf("abc")).status != 200)
    std::this_thread::yield();
}

TEST(HttpServerTest, ALongHeaderIsRefused) {
  const auto server = StartServer();
  const std::string fits =
      "GET /hello HTTP/1.1\r\nConnection: close\r\nA: " + std::string(7'000, 'a') + "\r\n\r\n";
  EXPECT_EQ(test_support::Exchange(server->port(), fits).status, 200);
  const std::string long_line =
      "GET /hello HTTP/1.1\r\nA: " + std::string(100'000, 'a') + "\r\n\r\n";
  EXPECT_EQ(test_support::Exchange(server->port(), long_line).status, 431);
  EXPECT_EQ(Get(server->port(), "/" + std::string(100'000, 'a')).status, 431);
}

TEST(HttpServerTest, AHeaderThatDoesNotEndIsDroppedInTime) {
  EXPECT_EQ(HttpLimits().patience, std::chrono::seconds(10));
  const auto server = StartServer({.patience = std::chrono::milliseconds(50)});
  HttpSocket socket(server->port());
  socket.Send("GET /hello HTTP/1.1\r\nA: ");
  EXPECT_EQ(socket.ReadAll(), "");
  HttpSocket slow(server->port());
  slow.Send("POST /hello HTTP/1.1\r\nContent-Length: 8\r\n\r\nabcd");
  EXPECT_EQ(slow.ReadAll(), "");
  HttpSocket idle(server->port());
  EXPECT_EQ(idle.ReadAll(), "");
}

TEST(HttpServerTest, BeyondTheBoundAConnectionWaitsUntilAnAnswerEnds) {
  const auto server = StartServer({.max_connections = 2, .patience = kPatient.patience});
  auto first = std::make_unique<HttpSocket>(server->port());
  HttpSocket second(server->port());
  for (HttpSocket* socket : {first.get(), &second}) {
    socket->Send("GET /parts HTTP/1.1\r\n\r\n");
    EXPECT_THAT(socket->ReadUntil("\r\n\r\n"), StartsWith("HTTP/1.1 200"));
  }
  HttpSocket third(server->port());
  third.Send("GET /hello?third HTTP/1.1\r\n\r\n");
  first.reset();
  EXPECT_THAT(third.ReadAnswer(), EndsWith("third\n"));
}

// 2,300 idle connections must not keep a health probe out.
TEST(HttpServerTest, BeyondTheBoundTheLongestIdleConnectionIsClosed) {
  std::vector<std::string> dropped;
  auto server = StartServer({.max_connections = 3, .patience = kPatient.patience},
                            [&](const std::string& peer) { dropped.push_back(peer); });
  HttpSocket busy(server->port());
  busy.Send("GET /parts HTTP/1.1\r\n\r\n");
  EXPECT_THAT(busy.ReadUntil("\r\n\r\n"), StartsWith("HTTP/1.1 200"));
  HttpSocket oldest(server->port());
  oldest.Send("GET /hello HTTP/1.1\r\n\r\n");
  EXPECT_THAT(oldest.ReadAnswer(), StartsWith("HTTP/1.1 200"));
  HttpSocket idle(server->port());
  idle.Send("GET /hello HTTP/1.1\r\n\r\n");
  EXPECT_THAT(idle.ReadAnswer(), StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(Get(server->port(), "/hello?probe").body, "probe\n");
  EXPECT_EQ(oldest.ReadAll(), "");
  idle.Send("GET /hello?idle HTTP/1.1\r\n\r\n");
  EXPECT_THAT(idle.ReadAnswer(), EndsWith("idle\n"));
  server.reset();  // ends its thread
  ASSERT_EQ(dropped.size(), 1u);
  EXPECT_THAT(dropped[0], StartsWith("ipv4:127.0.0.1:"));
}

TEST(HttpServerTest, TheServerAcceptsAgainAfterATimeWithoutDescriptors) {
  EXPECT_LE(HttpLimits().accept_retry, std::chrono::seconds(1));
  const auto server =
      StartServer({.patience = kPatient.patience, .accept_retry = std::chrono::milliseconds(1)});
  std::unique_ptr<HttpSocket> waiting;
  {
    NoDescriptors exhausted;
    exhausted.FreeOne();
    waiting = std::make_unique<HttpSocket>(server->port());
    waiting->Send("GET /hello?late HTTP/1.1\r\n\r\n");
    // This is long enough on most machines for some failed attempts of the server.
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  EXPECT_THAT(waiting->ReadAnswer(), EndsWith("late\n"));
}

TEST(HttpServerTest, AnUnavailableAddressIsAnError) {
  const auto server = StartServer();
  const std::string taken = "127.0.0.1:" + std::to_string(server->port());
  const absl::Status status = HttpServer::Start(taken, MakeEcho).status();
  EXPECT_TRUE(absl::IsUnavailable(status));
  EXPECT_THAT(std::string(status.message()), HasSubstr("for HTTP: cannot listen on " + taken));
  EXPECT_TRUE(absl::IsUnavailable(HttpServer::Start("203.0.113.1:0", MakeEcho).status()));
}

TEST(HttpServerTest, AnIpv6AddressStandsInBrackets) {
  const auto server = HttpServer::Start("[::1]:0", MakeEcho);
  if (!server.ok()) GTEST_SKIP() << "this machine has no IPv6: " << server.status();
  EXPECT_GT((*server)->port(), 0);
}

TEST(HttpServerTest, OpenConnectionsDoNotDelayTheEnd) {
  auto server = StartServer();
  HttpSocket idle(server->port());
  idle.Send("GET /hello HTTP/1.1\r\n\r\n");
  EXPECT_THAT(idle.ReadAnswer(), Not(::testing::IsEmpty()));
  server.reset();
  EXPECT_EQ(idle.ReadAll(), "");
}

}  // namespace
}  // namespace sweepstake::web
