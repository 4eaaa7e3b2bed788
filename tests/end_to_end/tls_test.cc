// Tests games and the real daemon with TLS: who may connect, which errors others get, and
// certificates that are replaced while both run.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <openssl/err.h>
#include <openssl/ssl.h>

#include <chrono>
#include <fstream>
#include <optional>

#include "tests/end_to_end/scripted_game.h"
#include "tests/support/daemon_process.h"
#include "tests/support/http_exchange.h"
#include "tests/support/temporary_directory.h"
#include "tests/support/test_authority.h"

namespace sweepstake::test_support {
namespace {

using ::testing::HasSubstr;

class TlsTest : public ::testing::Test {
 protected:
  TlsTest() {
    authority_.Issue("IP:127.0.0.1", server_);
    std::filesystem::copy_file(authority_.cert(), client_ca_);
  }

  std::string Path(const std::string& name) const { return (folder_.path() / name).string(); }
  std::vector<std::string> Flags(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> flags = {"--tls-cert", server_.cert, "--tls-key", server_.key};
    flags.insert(flags.end(), more.begin(), more.end());
    return flags;
  }
  std::vector<std::string> FlagsWithClientCa() const {
    return Flags({"--tls-client-ca", client_ca_});
  }

  TemporaryDirectory folder_;
  TemporaryDirectory data_;
  TestAuthority authority_{Path("ca.pem")};
  TestAuthority other_authority_{Path("other-ca.pem")};
  CertificateFiles server_{Path("server.pem"), Path("server-key.pem")};
  std::string client_ca_ = Path("client-ca.pem");  // the daemon's copy
  CertificateFiles client_{Path("client.pem"), Path("client-key.pem")};
  TlsOptions tls_{.ca_file = authority_.cert(), .cert_file = "", .key_file = "", .server_name = ""};
};

SessionOptions With(const std::optional<TlsOptions>& tls) {
  SessionOptions options = FastOptions();
  options.tls = tls;
  return options;
}

// Runs until evidence of the game is on the daemon's disk. Returns the error if it never connected,
// or an empty text.
std::string Play(const std::string& address, const std::optional<TlsOptions>& tls) {
  ScriptedGame game(address, With(tls));
  EXPECT_TRUE(game.RunUntil(
      [](const SessionStats& stats) { return IsConnected(stats) || !stats.last_error.empty(); }));
  return game.stats().last_error;
}

// Tries to connect for up to a minute; returns whether it succeeded.
bool PlaysInTheEnd(const std::string& address, const std::optional<TlsOptions>& tls) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  std::string problem;
  do {
    problem = Play(address, tls);
  } while (!problem.empty() && std::chrono::steady_clock::now() < deadline);
  return problem.empty();
}

// Returns whether the daemon accepts a client whose newest version of TLS is `version`.
bool AcceptsVersion(const std::string& address, int version) {
  SSL_CTX* context = SSL_CTX_new(TLS_client_method());
  SSL_CTX_set_min_proto_version(context, TLS1_VERSION);
  SSL_CTX_set_max_proto_version(context, version);
  SSL_CTX_set_cipher_list(context, "ALL:@SECLEVEL=0");  // so that the client allows old ciphers
  constexpr unsigned char kHttp2[] = {2, 'h', '2'};
  SSL_CTX_set_alpn_protos(context, kHttp2, sizeof kHttp2);
  BIO* connection = BIO_new_ssl_connect(context);
  BIO_set_conn_hostname(connection, address.c_str());
  const bool accepted = BIO_do_handshake(connection) == 1;
  BIO_free_all(connection);
  SSL_CTX_free(context);
  ERR_clear_error();  // gRPC uses the same error queue
  return accepted;
}

TEST_F(TlsTest, VersionsBefore1_2AreRefused) {
  const DaemonProcess daemon(data_.path(), "127.0.0.1:0", Flags());
  EXPECT_FALSE(AcceptsVersion(daemon.address(), TLS1_VERSION));
  EXPECT_FALSE(AcceptsVersion(daemon.address(), TLS1_1_VERSION));
  EXPECT_TRUE(AcceptsVersion(daemon.address(), TLS1_2_VERSION));
  EXPECT_TRUE(AcceptsVersion(daemon.address(), TLS1_3_VERSION));
}

TEST_F(TlsTest, AGameThatTrustsTheAuthorityLearns) {
  DaemonProcess daemon(data_.path(), "127.0.0.1:0", Flags());
  EXPECT_EQ(Play(daemon.address(), tls_), "");
  EXPECT_EQ(daemon.Terminate(), 0);
}

TEST_F(TlsTest, AGameThatTrustsAnotherAuthorityGetsAdviceToNameThisOne) {
  const DaemonProcess daemon(data_.path(), "127.0.0.1:0", Flags());
  tls_.ca_file = other_authority_.cert();
  EXPECT_THAT(Play(daemon.address(), tls_),
              HasSubstr("give the certificate of the authority that signed it"));
}

TEST_F(TlsTest, APlainTextGameGetsAdviceThatTheDaemonMayRequireTls) {
  const DaemonProcess daemon(data_.path(), "127.0.0.1:0", Flags());
  EXPECT_THAT(Play(daemon.address(), std::nullopt), HasSubstr("may require TLS"));
}

TEST_F(TlsTest, ATlsGameGetsAdviceThatTheDaemonUsesPlainText) {
  const DaemonProcess daemon(data_.path());
  EXPECT_THAT(Play(daemon.address(), tls_), HasSubstr("the daemon uses plain text"));
}

TEST_F(TlsTest, ACertificateForAnotherHostNeedsItsName) {
  authority_.Issue("DNS:sweepstake.example", server_);
  const DaemonProcess daemon(data_.path(), "127.0.0.1:0", Flags());
  EXPECT_THAT(Play(daemon.address(), tls_), HasSubstr("is for another host"));
  tls_.server_name = "sweepstake.example";
  EXPECT_EQ(Play(daemon.address(), tls_), "");
}

TEST_F(TlsTest, ADaemonWithAClientAuthorityAcceptsOnlyItsCertificates) {
  const DaemonProcess daemon(data_.path(), "127.0.0.1:0", FlagsWithClientCa());
  EXPECT_THAT(Play(daemon.address(), tls_), HasSubstr("may require a client certificate"));
  tls_.cert_file = client_.cert;
  tls_.key_file = client_.key;
  other_authority_.Issue("DNS:game", client_);
  EXPECT_THAT(Play(daemon.address(), tls_), HasSubstr("may require a client certificate"));
  authority_.Issue("DNS:game", client_);
  EXPECT_EQ(Play(daemon.address(), tls_), "");
}

TEST_F(TlsTest, AnExpiredClientCertificateIsRefused) {
  const DaemonProcess daemon(data_.path(), "127.0.0.1:0", FlagsWithClientCa());
  tls_.cert_file = client_.cert;
  tls_.key_file = client_.key;
  authority_.Issue("DNS:game", client_, /*expires_in_s=*/-60);
  EXPECT_THAT(Play(daemon.address(), tls_), HasSubstr("may require a client certificate"));
  authority_.Issue("DNS:game", client_);
  EXPECT_EQ(Play(daemon.address(), tls_), "");
}

TEST_F(TlsTest, AReplacedCertificateIsServedAndNoRunningStreamIsLost) {
  const DaemonProcess daemon(data_.path(), "127.0.0.1:0", Flags());
  ScriptedGame running(daemon.address(), With(tls_));
  ASSERT_TRUE(running.RunUntil(IsConnected));
  other_authority_.Issue("IP:127.0.0.1", server_);
  // A game that trusts the new authority retries until the daemon has read the new files.
  tls_.ca_file = other_authority_.cert();
  ScriptedGame next(daemon.address(), With(tls_));
  ASSERT_TRUE(next.RunUntil(IsConnected, UINT64_MAX));
  const uint64_t acknowledged = running.stats().acknowledged_sequence;
  ASSERT_TRUE(running.RunUntil(
      [&](const SessionStats& stats) { return stats.acknowledged_sequence > acknowledged; }));
  EXPECT_EQ(running.stats().connection_count, 1u);
  EXPECT_EQ(running.stats().last_error, "");
  EXPECT_EQ(running.stats().dropped_frame_count, 0u);
  // The old certificate must not be served any longer.
  tls_.ca_file = authority_.cert();
  EXPECT_THAT(Play(daemon.address(), tls_),
              HasSubstr("give the certificate of the authority that signed it"));
}

TEST_F(TlsTest, BrokenFilesAreReportedOnceAndNoRunningStreamIsLost) {
  auto flags = Flags();
  flags.insert(flags.end(), {"--http", "127.0.0.1:0"});
  const DaemonProcess daemon(data_.path(), "127.0.0.1:0", flags);
  const auto reloads = [&](int successful) {
    const std::string line =
        "\nsweepstake_tls_last_reload_successful " + std::to_string(successful) + "\n";
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    std::string metrics;
    while (metrics.find(line) == std::string::npos && std::chrono::steady_clock::now() < deadline)
      metrics = Get(daemon.http_port(), "/metrics").body;
    return metrics;
  };
  EXPECT_THAT(reloads(1), HasSubstr("\nsweepstake_tls_certificate_expiry_timestamp_seconds 1"));
  ScriptedGame running(daemon.address(), With(tls_));
  ASSERT_TRUE(running.RunUntil(IsConnected));
  EXPECT_THAT(daemon.log(), HasSubstr("days; clients refuse"));
  std::ofstream(server_.key) << "-----BEGIN PRIVATE KEY-----\nhalf of i";
  EXPECT_THAT(reloads(0), HasSubstr("sweepstake_tls_certificate_expiry_timestamp_seconds 1"));
  EXPECT_THAT(Get(daemon.http_port(), "/readyz").body,
              HasSubstr("[-]tls failed: the TLS files are invalid: " + server_.key.string()));
  const uint64_t acknowledged = running.stats().acknowledged_sequence;
  EXPECT_TRUE(running.RunUntil(
      [&](const SessionStats& stats) { return stats.acknowledged_sequence > acknowledged; }));
  authority_.Issue("IP:127.0.0.1", server_);
  reloads(1);
  EXPECT_EQ(Get(daemon.http_port(), "/readyz").body, "ok\n");
  // gRPC reads the files after some time.
  EXPECT_TRUE(PlaysInTheEnd(daemon.address(), tls_));
  EXPECT_EQ(running.stats().connection_count, 1u);
  const std::string log = daemon.log();
  const size_t told = log.find(server_.key.string() + " contains no unencrypted private key");
  ASSERT_NE(told, std::string::npos) << log;
  EXPECT_EQ(log.find("are invalid", told), std::string::npos) << "reported again";
}

TEST_F(TlsTest, AReplacedClientAuthorityIsUsedAndNoRunningStreamIsLost) {
  const DaemonProcess daemon(data_.path(), "127.0.0.1:0", FlagsWithClientCa());
  authority_.Issue("DNS:game", client_);
  tls_.cert_file = client_.cert;
  tls_.key_file = client_.key;
  ScriptedGame running(daemon.address(), With(tls_));
  ASSERT_TRUE(running.RunUntil(IsConnected));
  std::filesystem::rename(other_authority_.cert(), client_ca_);
  other_authority_.Issue("DNS:game", client_);
  ScriptedGame next(daemon.address(), With(tls_));
  ASSERT_TRUE(next.RunUntil(IsConnected, UINT64_MAX));
  EXPECT_EQ(running.stats().connection_count, 1u);
  EXPECT_EQ(running.stats().last_error, "");
}

TEST_F(TlsTest, AGameNamesItsMissingFilesAndConnectsOnceTheyAreBack) {
  std::optional<DaemonProcess> daemon;
  daemon.emplace(data_.path(), "127.0.0.1:0", Flags());
  const std::string address = daemon->address();
  ScriptedGame game(address, With(tls_));
  ASSERT_TRUE(game.RunUntil(IsConnected));
  std::filesystem::rename(tls_.ca_file, Path("away.pem"));
  daemon.reset();
  ASSERT_TRUE(game.RunUntil(
      [&](const SessionStats& stats) {
        return stats.last_error.find("cannot read " + tls_.ca_file) != std::string::npos;
      },
      UINT64_MAX));
  std::filesystem::rename(Path("away.pem"), tls_.ca_file);
  daemon.emplace(data_.path(), address, Flags());
  EXPECT_TRUE(game.RunUntil([](const SessionStats& stats) { return stats.connection_count == 2; },
                            UINT64_MAX));
}

TEST_F(TlsTest, UnusableFilesAreRefusedBeforeTheFirstConnection) {
  tls_.ca_file = Path("nowhere.pem");
  const auto session = MakeDaemonSession("127.0.0.1:1", With(tls_));
  EXPECT_EQ(session.status().code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(session.status().message(), HasSubstr("cannot read " + tls_.ca_file));
}

}  // namespace
}  // namespace sweepstake::test_support
