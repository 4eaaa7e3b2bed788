// The HTTP listener over real sockets: its pages, what it says to wrong requests, and its bounds.
#include "server/web/http_server.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/no_descriptors.h"
#include "tests/support/http_exchange.h"

namespace sweepstake::web {
namespace {

using test_support::Exchange;
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

std::unique_ptr<HttpServer> StartServer(HttpLimits limits = kPatient) {
  PageTable pages;
  pages["/hello"] = [](std::string_view query) {
    return Page{.body = "hello " + std::string(query) + "\n"};
  };
  pages["/broken"] = [](std::string_view /*query*/) { return Page{503, "broken\n", "text/x"}; };
  auto server = HttpServer::Start("127.0.0.1:0", std::move(pages), limits);
  EXPECT_TRUE(server.ok()) << server.status();
  return *std::move(server);
}

TEST(HttpServerTest, APageIsMadeFromTheQuery) {
  const auto server = StartServer();
  const HttpAnswer answer = Get(server->port(), "/hello?you");
  EXPECT_EQ(answer.status, 200);
  EXPECT_EQ(answer.body, "hello you\n");
  EXPECT_THAT(answer.head, AllOf(HasSubstr("Content-Type: text/plain; charset=utf-8\r\n"),
                                 HasSubstr("Cache-Control: no-store\r\n")));
  EXPECT_EQ(Get(server->port(), "/hello").body, "hello \n");
}

TEST(HttpServerTest, APageHasItsStatusAndType) {
  const auto server = StartServer();
  const HttpAnswer answer = Get(server->port(), "/broken");
  EXPECT_EQ(answer.status, 503);
  EXPECT_THAT(answer.head, HasSubstr("Content-Type: text/x\r\n"));
}

TEST(HttpServerTest, AHeadHasTheLengthAndNoBody) {
  const auto server = StartServer();
  const HttpAnswer answer =
      Exchange(server->port(), "HEAD /hello HTTP/1.1\r\nConnection: close\r\n\r\n");
  EXPECT_EQ(answer.status, 200);
  EXPECT_THAT(answer.head, HasSubstr("Content-Length: 7\r\n"));
  EXPECT_EQ(answer.body, "");
}

TEST(HttpServerTest, AConnectionServesManyRequestsEvenIfAllAreSentAtOnce) {
  const auto server = StartServer();
  HttpSocket socket(server->port());
  socket.Send("GET /hello?1 HTTP/1.1\r\n\r\nGET /hello?2 HTTP/1.1\r\n\r\n");
  EXPECT_THAT(socket.ReadAnswer(), EndsWith("hello 1\n"));
  EXPECT_THAT(socket.ReadAnswer(), EndsWith("hello 2\n"));
  socket.Send("GET /hello?3 HTTP/1.1\r\n\r\n");
  EXPECT_THAT(socket.ReadAnswer(), EndsWith("hello 3\n"));
}

TEST(HttpServerTest, AnUnknownPathIsAnsweredWithThePaths) {
  const auto server = StartServer();
  for (const std::string target :
       {"/", "/hell", "/hello/", "/../etc/passwd", "/%2e%2e/etc/passwd", "/hello%00", "//hello"}) {
    const HttpAnswer answer = Get(server->port(), target);
    EXPECT_EQ(answer.status, 404) << target;
    EXPECT_THAT(answer.body, HasSubstr("There are /broken, /hello.")) << target;
  }
}

TEST(HttpServerTest, OnlyGetAndHeadAreValid) {
  const auto server = StartServer();
  for (const std::string method :
       {"POST", "PUT", "DELETE", "OPTIONS", "TRACE", "PATCH", "FROBNICATE"}) {
    const HttpAnswer answer =
        Exchange(server->port(), method + " /hello HTTP/1.1\r\nConnection: close\r\n\r\n");
    EXPECT_EQ(answer.status, 405) << method;
    EXPECT_THAT(answer.head, HasSubstr("Allow: GET, HEAD\r\n")) << method;
    EXPECT_THAT(answer.body, HasSubstr("Only GET and HEAD")) << method;
  }
}

TEST(HttpServerTest, WhatIsNoRequestIsAnsweredAndTheConnectionEnds) {
  const auto server = StartServer();
  for (const std::string request :
       {"hello\r\n\r\n", "GET\r\n\r\n", "GET /hello HTTP/9.9\r\n\r\n", "GET /hello\r\n\r\n",
        "\x16\x03\x01\x02 a TLS handshake\r\n\r\n", "GET /hello HTTP/1.1\r\nno colon\r\n\r\n",
        "GET http://localhost/hello HTTP/1.1\r\nConnection: close\r\n\r\n",
        "GET * HTTP/1.1\r\nConnection: close\r\n\r\n"}) {
    const HttpAnswer answer = Exchange(server->port(), request);
    EXPECT_EQ(answer.status, 400) << request;
    EXPECT_THAT(answer.head, HasSubstr("Connection: close\r\n")) << request;
  }
  EXPECT_EQ(Get(server->port(), "/hello").status, 200);
}

TEST(HttpServerTest, ABodyIsRefused) {
  const auto server = StartServer();
  EXPECT_EQ(Exchange(server->port(), "GET /hello HTTP/1.1\r\nContent-Length: 3\r\n\r\nabc").status,
            413);
  EXPECT_EQ(Exchange(server->port(),
                     "POST /hello HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n3\r\nabc\r\n")
                .status,
            413);
}

TEST(HttpServerTest, ALongHeaderIsRefused) {
  const auto server = StartServer();
  const std::string fits =
      "GET /hello HTTP/1.1\r\nConnection: close\r\nA: " + std::string(7'000, 'a') + "\r\n\r\n";
  EXPECT_EQ(Exchange(server->port(), fits).status, 200);
  const std::string long_line =
      "GET /hello HTTP/1.1\r\nA: " + std::string(100'000, 'a') + "\r\n\r\n";
  EXPECT_EQ(Exchange(server->port(), long_line).status, 431);
  EXPECT_EQ(Get(server->port(), "/" + std::string(100'000, 'a')).status, 431);
}

TEST(HttpServerTest, AHeaderThatDoesNotEndIsDroppedInTime) {
  EXPECT_EQ(HttpLimits().patience, std::chrono::seconds(10));
  const auto server = StartServer({.patience = std::chrono::milliseconds(50)});
  HttpSocket socket(server->port());
  socket.Send("GET /hello HTTP/1.1\r\nA: ");
  EXPECT_EQ(socket.ReadAll(), "");
  HttpSocket idle(server->port());
  EXPECT_EQ(idle.ReadAll(), "");
}

TEST(HttpServerTest, BeyondTheBoundAConnectionWaitsUntilAnotherEnds) {
  const auto server = StartServer({.max_connections = 2, .patience = kPatient.patience});
  auto first = std::make_unique<HttpSocket>(server->port());
  HttpSocket second(server->port());
  HttpSocket third(server->port());
  for (HttpSocket* socket : {first.get(), &second}) {
    socket->Send("GET /hello HTTP/1.1\r\n\r\n");
    EXPECT_THAT(socket->ReadAnswer(), StartsWith("HTTP/1.1 200"));
  }
  third.Send("GET /hello?third HTTP/1.1\r\n\r\n");
  first.reset();
  EXPECT_THAT(third.ReadAnswer(), EndsWith("hello third\n"));
}

TEST(HttpServerTest, ATimeWithoutDescriptorsPasses) {
  EXPECT_LE(HttpLimits().accept_retry, std::chrono::seconds(1));
  const auto server =
      StartServer({.patience = kPatient.patience, .accept_retry = std::chrono::milliseconds(1)});
  std::unique_ptr<HttpSocket> waiting;
  {
    NoDescriptors exhausted;
    exhausted.FreeOne();
    waiting = std::make_unique<HttpSocket>(server->port());
    waiting->Send("GET /hello?late HTTP/1.1\r\n\r\n");
    // Long enough for the server to try in vain, on most machines.
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  EXPECT_THAT(waiting->ReadAnswer(), EndsWith("hello late\n"));
}

TEST(HttpServerTest, AnAddressThatCannotBeHadIsAnError) {
  const auto server = StartServer();
  const std::string taken = "127.0.0.1:" + std::to_string(server->port());
  const absl::Status status = HttpServer::Start(taken, {}).status();
  EXPECT_TRUE(absl::IsUnavailable(status));
  EXPECT_THAT(std::string(status.message()), HasSubstr("for HTTP: cannot listen on " + taken));
  EXPECT_TRUE(absl::IsUnavailable(HttpServer::Start("203.0.113.1:0", {}).status()));
}

TEST(HttpServerTest, AnIpv6AddressStandsInBrackets) {
  const auto server = HttpServer::Start("[::1]:0", {});
  if (!server.ok()) GTEST_SKIP() << "this machine has no IPv6: " << server.status();
  EXPECT_GT((*server)->port(), 0);
}

TEST(HttpServerTest, OpenConnectionsDoNotHoldUpTheEnd) {
  auto server = StartServer();
  HttpSocket idle(server->port());
  idle.Send("GET /hello HTTP/1.1\r\n\r\n");
  EXPECT_THAT(idle.ReadAnswer(), Not(::testing::IsEmpty()));
  server.reset();
  EXPECT_EQ(idle.ReadAll(), "");
}

}  // namespace
}  // namespace sweepstake::web
