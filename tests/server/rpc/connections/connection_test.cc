// Tests connections with invalid or incomplete HTTP/2, over real sockets.
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <deque>
#include <future>
#include <vector>

#include "server/net/peer_address.h"
#include "server/rpc/connection_calls.h"
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

// A socket that listens on all IPv4 addresses, or connects from its own port to one of these
// addresses.
class TcpSocket {
 public:
  explicit TcpSocket(int descriptor = socket(AF_INET, SOCK_STREAM, 0)) : descriptor_(descriptor) {
    const int yes = 1;
    setsockopt(descriptor_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  }
  ~TcpSocket() { close(descriptor_); }
  TcpSocket(const TcpSocket&) = delete;
  TcpSocket& operator=(const TcpSocket&) = delete;

  int descriptor() const { return descriptor_; }
  bool Bind(uint32_t address, int port) {
    const sockaddr_in own = Endpoint(address, port);
    return bind(descriptor_, reinterpret_cast<const sockaddr*>(&own), sizeof own) == 0;
  }
  bool Connect(uint32_t address, int port) {
    const sockaddr_in other = Endpoint(address, port);
    return connect(descriptor_, reinterpret_cast<const sockaddr*>(&other), sizeof other) == 0;
  }
  int port() const {
    sockaddr_in own{};
    socklen_t size = sizeof own;
    getsockname(descriptor_, reinterpret_cast<sockaddr*>(&own), &size);
    return ntohs(own.sin_port);
  }
  bool ended() const {
    char byte = 0;
    return recv(descriptor_, &byte, 1, MSG_DONTWAIT) == 0;
  }

 private:
  static sockaddr_in Endpoint(uint32_t address, int port) {
    sockaddr_in endpoint{};
    endpoint.sin_family = AF_INET;
    endpoint.sin_addr.s_addr = htonl(address);
    endpoint.sin_port = htons(static_cast<uint16_t>(port));
    return endpoint;
  }

  const int descriptor_;
};

TEST(ConnectionCallsTest, TwoConnectionsOfOnePeerAreCountedAndEndedTogether) {
  constexpr uint32_t kAddresses[] = {INADDR_LOOPBACK, INADDR_LOOPBACK + 1};
  TcpSocket listener;
  ASSERT_TRUE(listener.Bind(INADDR_ANY, 0));
  ASSERT_EQ(listen(listener.descriptor(), 2), 0);
  std::atomic<uint64_t> ended = 0;
  ConnectionCalls calls(/*max_calls=*/2, ended);
  TcpSocket clients[2];
  ASSERT_TRUE(clients[0].Bind(INADDR_LOOPBACK, 0));
  std::deque<TcpSocket> accepted;
  for (size_t i = 0; i < 2; ++i) {
    ASSERT_TRUE(i == 0 || clients[1].Bind(INADDR_LOOPBACK, clients[0].port()));
    ASSERT_TRUE(clients[i].Connect(kAddresses[i], listener.port()));
    calls.Add(accepted.emplace_back(accept(listener.descriptor(), nullptr, nullptr)).descriptor());
  }
  const std::string name = net::PeerOf(accepted[0].descriptor());
  ASSERT_EQ(net::PeerOf(accepted[1].descriptor()), name);
  const auto peer = calls.Begin(name);
  ASSERT_TRUE(peer);
  calls.Begin(name);
  calls.End(*peer);
  calls.Begin(name);
  EXPECT_EQ(ended, 0u);
  calls.Begin(name);
  EXPECT_EQ(ended, 1u);
  for (const TcpSocket& client : clients) EXPECT_TRUE(Eventually([&] { return client.ended(); }));
}

TEST_F(ConnectionTest, AConnectionThatBeginsCallsTooFastIsEnded) {
  options_.max_streams_per_connection = 1;
  RestartServer();
  const auto& ended = server_->counters().flooding_connection_count;
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
