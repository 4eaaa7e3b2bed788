// Tests games and the real daemon with a real HAProxy between them, configured as in
// deploy/haproxy/.
#include <arpa/inet.h>
#include <errno.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include <fstream>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "sweepstake/v1/posteriors.grpc.pb.h"
#include "tests/end_to_end/scripted_game.h"
#include "tests/server/rpc/http2_frames.h"
#include "tests/support/child_process.h"
#include "tests/support/daemon_process.h"
#include "tests/support/file_text.h"
#include "tests/support/http_exchange.h"
#include "tests/support/temporary_directory.h"
#include "tests/support/test_authority.h"

namespace sweepstake::test_support {
namespace {

sockaddr_in Loopback(const char* address, int port) {
  sockaddr_in endpoint{};
  endpoint.sin_family = AF_INET;
  endpoint.sin_port = htons(static_cast<uint16_t>(port));
  inet_pton(AF_INET, address, &endpoint.sin_addr);
  return endpoint;
}

// HAProxy with the configuration of deploy/, on its own port.
class Haproxy {
 public:
  // `settings` are environment variables in the form "NAME=VALUE".
  Haproxy(const std::filesystem::path& folder, const std::string& daemon,
          const std::filesystem::path& certificate, const std::vector<std::string>& settings)
      : socket_(Listen()),
        process_(CommandLine(daemon, certificate, settings), folder / "haproxy.log") {
    close(socket_);  // HAProxy has inherited it
    AwaitStart(1);
  }
  // Ends HAProxy by SIGTERM. After kill -9 its worker process would continue.
  ~Haproxy() { process_.Terminate(); }

  int port() const { return port_; }
  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }
  // Starts a new process that reads HAProxy's files; the former process keeps its connections.
  void Reload() {
    process_.Signal(SIGUSR2);
    AwaitStart(2);
  }

 private:
  int Listen() {
    const int listener = socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in endpoint = Loopback("127.0.0.1", 0);
    socklen_t size = sizeof endpoint;
    if (bind(listener, reinterpret_cast<sockaddr*>(&endpoint), size) != 0 ||
        listen(listener, SOMAXCONN) != 0 ||
        getsockname(listener, reinterpret_cast<sockaddr*>(&endpoint), &size) != 0) {
      ADD_FAILURE() << "no port to listen on";
    }
    port_ = ntohs(endpoint.sin_port);
    return listener;
  }
  std::vector<std::string> CommandLine(const std::string& daemon,
                                       const std::filesystem::path& certificate,
                                       const std::vector<std::string>& settings) const {
    std::vector<std::string> line = {"env",
                                     "PATH=/usr/sbin:/usr/bin",
                                     "GAMES_ADDRESS=fd@" + std::to_string(socket_),
                                     "DAEMON_ADDRESS=" + daemon,
                                     "CERTIFICATE=" + certificate.string(),
                                     "INNER_SOCKET=sweepstake-test-" + std::to_string(port_)};
    line.insert(line.end(), settings.begin(), settings.end());
    line.insert(line.end(), {"haproxy", "-W", "-db", "-f", HAPROXY_CONFIG});
    return line;
  }
  void AwaitStart(int count) {
    const auto starts = [this] {
      const std::string said = process_.log();
      int found = 0;
      for (size_t at = 0; (at = said.find("Loading success", at)) != std::string::npos; ++at)
        ++found;
      return found;
    };
    while (starts() < count) {
      ASSERT_FALSE(process_.ended()) << "tests/run.sh installs it; it said:\n" << process_.log();
      usleep(5'000);
    }
  }

  int port_ = 0;
  int socket_;
  ChildProcess process_;
};

// A client that sends data that no game would send.
class RawClient {
 public:
  // Connects from `source`, an address of the loopback.
  explicit RawClient(int port, const char* source = "127.0.0.1")
      : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    const sockaddr_in own = Loopback(source, 0);
    const sockaddr_in other = Loopback("127.0.0.1", port);
    const timeval patience{.tv_sec = 60, .tv_usec = 0};
    setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    bind(socket_, reinterpret_cast<const sockaddr*>(&own), sizeof own);
    connect(socket_, reinterpret_cast<const sockaddr*>(&other), sizeof other);
  }
  ~RawClient() {
    SSL_free(ssl_);
    SSL_CTX_free(context_);
    close(socket_);
    ERR_clear_error();  // gRPC uses the same error queue
  }
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  // Starts TLS; returns whether the handshake succeeded.
  bool Handshake() {
    context_ = SSL_CTX_new(TLS_client_method());
    ssl_ = SSL_new(context_);
    constexpr unsigned char kHttp2[] = {2, 'h', '2'};
    SSL_set_alpn_protos(ssl_, kHttp2, sizeof kHttp2);
    SSL_set_fd(ssl_, socket_);
    return SSL_connect(ssl_) == 1;
  }
  bool Send(std::string_view bytes) {
    return SSL_write(ssl_, bytes.data(), static_cast<int>(bytes.size())) > 0;
  }
  // Reads until `bytes` have arrived; returns false if the connection ends before.
  bool AwaitBytes(std::string_view bytes) {
    std::string read;
    while (read.find(bytes) == std::string::npos) {
      char more[4096];
      const int size = SSL_read(ssl_, more, sizeof more);
      if (size <= 0) return false;
      read.append(more, static_cast<size_t>(size));
    }
    return true;
  }
  // Reads until the other side closes the connection; returns whether it does within a minute.
  bool AwaitEnd() {
    char unread[4096];
    if (ssl_ == nullptr) return recv(socket_, unread, sizeof unread, 0) <= 0 && errno != EAGAIN;
    while (SSL_read(ssl_, unread, sizeof unread) > 0) {
    }
    return errno != EAGAIN;
  }

 private:
  int socket_;
  SSL_CTX* context_ = nullptr;
  SSL* ssl_ = nullptr;
};

// Returns the HTTP/2 frames that begin a telemetry call and reset it at once.
std::string RequestAndReset(uint32_t stream) {
  return Http2Call(stream, "/sweepstake.v1.TelemetryService/StreamTelemetry") + Http2Reset(stream);
}

class HaproxyTest : public ::testing::Test {
 protected:
  void Start(const std::vector<std::string>& settings = {}) {
    IssueCertificate(authority_);
    haproxy_ =
        std::make_unique<Haproxy>(folder_.path(), daemon_.address(), Path("haproxy.pem"), settings);
  }
  std::filesystem::path Path(const std::string& name) const { return folder_.path() / name; }
  // Writes certificate and key into one file, as HAProxy requires.
  void IssueCertificate(const TestAuthority& authority) const {
    const CertificateFiles parts{Path("cert.pem"), Path("key.pem")};
    authority.Issue("IP:127.0.0.1", parts);
    std::ofstream(Path("haproxy.pem")) << FileText(parts.cert) << FileText(parts.key);
  }
  static SessionOptions Trusting(const TestAuthority& authority) {
    SessionOptions options = FastOptions();
    options.tls.emplace().ca_file = authority.cert();
    return options;
  }
  double Metric(const std::string& name) const {
    const std::string page = "\n" + Get(daemon_.http_port(), "/metrics").body;
    const size_t line = page.find("\n" + name + " ");
    return line == std::string::npos ? -1 : std::stod(page.substr(line + name.size() + 2));
  }

  TemporaryDirectory folder_;
  TemporaryDirectory data_;
  TestAuthority authority_{Path("ca.pem")};
  TestAuthority other_authority_{Path("other-ca.pem")};
  DaemonProcess daemon_{data_.path(), "127.0.0.1:0", {"--http", "127.0.0.1:0"}};
  std::unique_ptr<Haproxy> haproxy_;
};

TEST_F(HaproxyTest, AGameLearnsThroughTheProxy) {
  Start();
  ScriptedGame game(haproxy_->address(), Trusting(authority_));
  ASSERT_TRUE(game.RunUntil([&](const SessionStats& stats) {
    return stats.acknowledged_sequence >= 40 && game.adaptive().active_arm() == kScriptedBest;
  })) << game.stats().last_error;
  game.Stop();
  EXPECT_EQ(game.stats().connection_count, 1u);
  EXPECT_EQ(game.stats().dropped_frame_count, 0u);
  EXPECT_EQ(game.stats().acknowledged_sequence, game.stats().sent_sequence)
      << "goodbye is answered when all is on disk";
  EXPECT_EQ(Metric("sweepstake_ended_sessions_total"), 1);
}

// HAProxy resets the stream of a call that the daemon refuses, so gRPC's own status is that of a
// reset.
TEST_F(HaproxyTest, AGameLearnsWhyItIsRefused) {
  Start();
  SessionOptions options = Trusting(authority_);
  options.policy = "nonsense";
  ScriptedGame game(haproxy_->address(), options);
  ASSERT_TRUE(game.RunUntil([](const SessionStats& stats) { return !stats.refusal.empty(); }));
  const std::string refusal = game.stats().refusal;
  EXPECT_TRUE(refusal.starts_with("unknown policy 'nonsense'")) << refusal;
  EXPECT_TRUE(refusal.ends_with(" (UNKNOWN_POLICY)")) << refusal;
}

TEST_F(HaproxyTest, AReloadedCertificateIsServedAndNoRunningStreamIsLost) {
  Start();
  ScriptedGame running(haproxy_->address(), Trusting(authority_));
  ASSERT_TRUE(running.RunUntil(IsConnected)) << running.stats().last_error;
  IssueCertificate(other_authority_);
  haproxy_->Reload();
  ScriptedGame next(haproxy_->address(), Trusting(other_authority_));
  ASSERT_TRUE(next.RunUntil(IsConnected, UINT64_MAX));
  const uint64_t acknowledged = running.stats().acknowledged_sequence;
  ASSERT_TRUE(running.RunUntil(
      [&](const SessionStats& stats) { return stats.acknowledged_sequence > acknowledged; }));
  EXPECT_EQ(running.stats().connection_count, 1u);
  EXPECT_EQ(running.stats().last_error, "");
}

TEST_F(HaproxyTest, OnlyTelemetryPassesAndRequestsPerAddressAreLimited) {
  Start({"REQUESTS_PER_ADDRESS=2"});
  grpc::SslCredentialsOptions trust;
  trust.pem_root_certs = FileText(authority_.cert());
  const auto stub = v1::PosteriorsService::NewStub(
      grpc::CreateChannel(haproxy_->address(), grpc::SslCredentials(trust)));
  for (const grpc::StatusCode answer :
       {grpc::StatusCode::UNIMPLEMENTED, grpc::StatusCode::UNIMPLEMENTED,
        grpc::StatusCode::UNAVAILABLE}) {
    grpc::ClientContext context;
    v1::ListPosteriorsResponse response;
    const grpc::Status status = stub->ListPosteriors(&context, {}, &response);
    EXPECT_EQ(status.error_code(), answer) << status.error_message();
  }
}

TEST_F(HaproxyTest, ASilentClientIsDisconnectedAtEveryStage) {
  Start();
  RawClient before_tls(haproxy_->port());
  RawClient after_tls(haproxy_->port());
  ASSERT_TRUE(after_tls.Handshake());
  RawClient after_preface(haproxy_->port());
  ASSERT_TRUE(after_preface.Handshake() && after_preface.Send(Http2Preface()));
  RawClient inside_headers(haproxy_->port());
  ASSERT_TRUE(inside_headers.Handshake() && inside_headers.Send(Http2Preface()));
  ASSERT_TRUE(inside_headers.Send(RequestAndReset(1).substr(0, 20)));
  for (RawClient* client : {&before_tls, &after_tls, &after_preface, &inside_headers})
    EXPECT_TRUE(client->AwaitEnd());
}

TEST_F(HaproxyTest, ConnectionsPerAddressAreLimited) {
  Start({"CONNECTIONS_PER_ADDRESS=2"});
  RawClient first(haproxy_->port(), "127.0.0.2");
  ASSERT_TRUE(first.Handshake());
  RawClient second(haproxy_->port(), "127.0.0.2");
  ASSERT_TRUE(second.Handshake());
  RawClient third(haproxy_->port(), "127.0.0.2");
  EXPECT_FALSE(third.Handshake());
  ScriptedGame game(haproxy_->address(), Trusting(authority_));
  EXPECT_TRUE(game.RunUntil(IsConnected)) << game.stats().last_error;
}

TEST_F(HaproxyTest, ARapidResetAttackIsDisconnectedAndGamesPlayOn) {
  Start();
  ScriptedGame game(haproxy_->address(), Trusting(authority_));
  ASSERT_TRUE(game.RunUntil(IsConnected)) << game.stats().last_error;
  RawClient attacker(haproxy_->port(), "127.0.0.2");
  ASSERT_TRUE(attacker.Handshake() && attacker.Send(Http2Preface()));
  for (uint32_t stream = 1; stream < 1'000; stream += 2)
    ASSERT_TRUE(attacker.Send(RequestAndReset(stream)));
  // HAProxy answers a ping after it has read everything sent before the ping.
  const std::string_view payload = "12345678";
  ASSERT_TRUE(attacker.Send(Http2Frame(Http2Type::kPing, 0, 0, payload)));
  ASSERT_TRUE(attacker.AwaitBytes(Http2Frame(Http2Type::kPing, 1, 0, payload)));
  EXPECT_FALSE(RawClient(haproxy_->port(), "127.0.0.2").Handshake());
  const uint64_t acknowledged = game.stats().acknowledged_sequence;
  ASSERT_TRUE(game.RunUntil(
      [&](const SessionStats& stats) { return stats.acknowledged_sequence > acknowledged; }));
  EXPECT_EQ(game.stats().connection_count, 1u);
}

// Each connection makes 100 calls. One announces 100 MB, one sends a compressed message, the others
// send nothing. HAProxy refuses further connections of the attacker.
TEST_F(HaproxyTest, CallsWithoutAReadableMessageDisturbNoGame) {
  Start();
  ScriptedGame game(haproxy_->address(), Trusting(authority_));
  ASSERT_TRUE(game.RunUntil(IsConnected)) << game.stats().last_error;
  std::string calls = Http2Preface();
  for (uint32_t stream = 1; stream < 200; stream += 2)
    calls += Http2Call(stream, "/sweepstake.v1.TelemetryService/StreamTelemetry");
  calls += Http2Frame(Http2Type::kData, 0, 1, std::string("\0\x06\0\0\0", 5));
  calls += Http2Frame(Http2Type::kData, 0, 3, std::string("\1\0\0\0\1", 5));
  std::vector<std::unique_ptr<RawClient>> attackers;
  bool is_admitted = true;
  for (int i = 0; i < 50 && is_admitted; ++i) {
    attackers.push_back(std::make_unique<RawClient>(haproxy_->port(), "127.0.0.2"));
    is_admitted = attackers.back()->Handshake() && attackers.back()->Send(calls);
    ASSERT_TRUE(is_admitted || i > 0);
  }
  const uint64_t acknowledged = game.stats().acknowledged_sequence;
  ASSERT_TRUE(game.RunUntil(
      [&](const SessionStats& stats) { return stats.acknowledged_sequence > acknowledged + 20; }));
  EXPECT_EQ(game.stats().connection_count, 1u);
}

}  // namespace
}  // namespace sweepstake::test_support
