// Tests connections with invalid or incomplete HTTP/2, over real sockets.
#include <future>
#include <vector>

#include "tests/server/rpc/http2_frames.h"
#include "tests/server/rpc/rpc_test_fixture.h"
#include "tests/support/http_exchange.h"

namespace sweepstake::rpc {
namespace {

using test_support::Http2Call;
using test_support::Http2Frame;
using test_support::Http2Preface;
using test_support::Http2Reset;
using test_support::Http2Type;
using test_support::HttpSocket;
using ::testing::HasSubstr;

class ConnectionTest : public RpcTest {};

TEST_F(ConnectionTest, AHalfOpenConnectionIsClosedAndOneWithAStreamStays) {
  EXPECT_EQ(options_.handshake_patience, std::chrono::seconds(10));
  options_.handshake_patience = std::chrono::milliseconds(100);
  RestartServer();
  TelemetryClient client(channel_);
  client.Open(HelloMessage());
  for (const std::string& begun : {std::string(), std::string("PRI * HTTP/2.0\r\n"),
                                   Http2Preface().substr(0, Http2Preface().size() - 1)}) {
    HttpSocket half_open(server_->port());
    half_open.Send(begun);
    half_open.ReadAll();
  }
  client.Send(Frames(1, 30));
  EXPECT_TRUE(Applied(1));
}

TEST_F(ConnectionTest, AConnectionWithoutHttp2IsClosed) {
  for (const std::string bytes : {"GET / HTTP/1.1\r\n\r\n", "\x16\x03\x01\x02 a TLS handshake"}) {
    HttpSocket socket(server_->port());
    socket.Send(bytes);
    socket.ReadAll();
  }
  TelemetryClient(channel_).Open(HelloMessage());
}

TEST_F(ConnectionTest, AnOldConnectionIsAskedToEndAndThenClosed) {
  options_.connection_age = std::chrono::milliseconds(100);
  options_.connection_age_grace = std::chrono::milliseconds(100);
  RestartServer();
  TelemetryClient client(channel_);
  client.Send(Request(OneArmHello()));
  EXPECT_EQ(client.Finish().error_code(), grpc::StatusCode::UNAVAILABLE);
  HttpSocket socket(server_->port());
  socket.Send(Http2Preface());
  socket.ReadAll();
}

TEST_F(ConnectionTest, AConnectionWithoutACallIsClosedAndOneWithAStreamStays) {
  options_.connection_idle_patience = std::chrono::milliseconds(100);
  // The interval is so long that the keepalive does not end a connection.
  options_.keepalive_interval = std::chrono::hours(1);
  RestartServer();
  TelemetryClient client(channel_);
  client.Open(HelloMessage());
  HttpSocket idle(server_->port());
  idle.Send(Http2Preface());
  idle.ReadAll();
  client.Send(Frames(1, 30));
  EXPECT_TRUE(Applied(1));
}

TEST_F(ConnectionTest, AConnectionThatDoesNotAnswerPingsIsClosed) {
  options_.keepalive_interval = std::chrono::milliseconds(100);
  options_.keepalive_patience = std::chrono::milliseconds(100);
  RestartServer();
  TelemetryClient client(channel_);
  client.Open(OneArmHello());
  HttpSocket silent(server_->port());
  silent.Send(Http2Preface());
  silent.ReadAll();
  client.Send(Frames(1, 30));
  EXPECT_TRUE(Applied(1)) << "the connection of a client that answers stays open";
}

TEST_F(ConnectionTest, AFloodOfPingsIsAnsweredWithGoAway) {
  HttpSocket socket(server_->port());
  socket.Send(Http2Preface());
  for (int i = 0; i < 100; ++i) socket.Send(Http2Frame(Http2Type::kPing, 0, 0, "12345678"));
  EXPECT_THAT(socket.ReadAll(), HasSubstr("too_many_pings"));
  TelemetryClient(channel_).Open(HelloMessage());
}

TEST_F(ConnectionTest, AConnectionThatResetsTooManyCallsIsEnded) {
  const auto& ended = server_->counters().refused_connection_count;
  uint64_t count = 0;
  for (const std::string method :
       {"/sweepstake.v1.TelemetryService/StreamTelemetry", "/no.such.Service/Method"}) {
    HttpSocket socket(server_->port());
    socket.Send(Http2Preface());
    uint32_t stream = 1;
    EXPECT_TRUE(Eventually([&] {
      socket.Send(Http2Call(stream, method) + Http2Reset(stream));
      stream += 2;
      return ended > count;
    })) << method;
    socket.ReadAll();
    EXPECT_EQ(ended, ++count);
  }
  TelemetryClient(channel_).Open(HelloMessage());
}

TEST_F(ConnectionTest, ACallEndsAtTheAnnouncementOfALongOrCompressedMessage) {
  const auto& unread = server_->counters().unread_call_count;
  HttpSocket socket(server_->port());
  socket.Send(Http2Preface());
  uint32_t stream = 1;
  for (const std::string& prefix : {std::string("\0\x06\0\0\0", 5), std::string("\1\0\0\0\1", 5)}) {
    socket.Send(Http2Call(stream, "/sweepstake.v1.TelemetryService/StreamTelemetry") +
                Http2Frame(Http2Type::kData, 0, stream, prefix));
    const uint64_t expected = (stream + 1) / 2;
    EXPECT_TRUE(Eventually([&] { return unread == expected; })) << stream;
    stream += 2;
  }
  TelemetryClient(channel_).Open(HelloMessage());
}

TEST_F(ConnectionTest, AStreamAboveTheLimitWaitsUntilAnotherEnds) {
  options_.max_streams_per_connection = 3;
  RestartServer();
  std::vector<std::unique_ptr<TelemetryClient>> clients;
  for (int i = 0; i < 3; ++i) {
    clients.push_back(std::make_unique<TelemetryClient>(channel_));
    clients.back()->Open(HelloMessage());
  }
  auto welcome = std::async(std::launch::async,
                            [this] { return TelemetryClient(channel_).Open(HelloMessage()); });
  // This takes long enough on most machines for the welcome message, if the fourth stream did not
  // wait.
  for (uint64_t sequence = 1; sequence <= 100; ++sequence) {
    clients[0]->Send(Frames(sequence, 30));
    ASSERT_TRUE(Applied(sequence));
    Tick();
    clients[0]->AwaitAcknowledgement(sequence);
  }
  EXPECT_EQ(server_->counters().connected_stream_count, 3u);
  clients.pop_back();
  EXPECT_FALSE(welcome.get().session_id().empty());
  EXPECT_EQ(server_->counters().connected_stream_count, 4u);
}

}  // namespace
}  // namespace sweepstake::rpc
