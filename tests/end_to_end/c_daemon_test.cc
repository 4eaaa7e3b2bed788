// Tests a game in C with the library of c_daemon.h and the real daemon: in plain text, with TLS and
// a token, and after the daemon was killed. The test program contains the C++ session too, so both
// can be in one process.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <chrono>
#include <optional>
#include <string>
#include <thread>

#include "tests/engine_client/c_api/daemon_game.h"
#include "tests/support/daemon_process.h"
#include "tests/support/temporary_directory.h"
#include "tests/support/test_authority.h"

namespace sweepstake::test_support {
namespace {

class CDaemonTest : public ::testing::Test {
 protected:
  CDaemonTest() {
    authority_.Issue("IP:127.0.0.1", server_);
    options_.struct_size = sizeof options_;
  }
  ~CDaemonTest() override { daemon_game_end(&game_, 0); }

  std::string Path(const std::string& name) const { return (folder_.path() / name).string(); }

  // Makes the daemon require a token, and returns the file that contains one.
  std::string CreateToken(const std::string& role) const {
    const std::string file = Path(role + ".token");
    const std::string command = std::string(SWEEPSTAKED_PATH) + " token create " + role +
                                " --role " + role + " --out " + file + " --data " +
                                data_.path().string() + " > /dev/null";
    EXPECT_EQ(system(command.c_str()), 0);
    return file;
  }
  void StartDaemonWithTls() {
    daemon_.emplace(data_.path(), "127.0.0.1:0",
                    std::vector<std::string>{"--tls-cert", server_.cert, "--tls-key", server_.key});
  }
  void StartGame() {
    address_ = daemon_->address();
    options_.address = address_.c_str();
    ASSERT_EQ(daemon_game_start(&game_, &options_), SWP_OK) << swp_last_error();
  }
  // Runs frames until the condition holds. A wait that never succeeds ends with the test's limit.
  template <typename Condition>
  void PlayUntil(const Condition& condition) {
    while (!condition(daemon_game_stats(&game_))) {
      daemon_game_frame(&game_);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  std::string Text(swp_link_text which) const { return daemon_game_text(&game_, which); }
  std::string PlayUntilRefused() {
    PlayUntil([this](const swp_link_stats& /*stats*/) { return !Text(SWP_LINK_REFUSAL).empty(); });
    return Text(SWP_LINK_REFUSAL);
  }
  std::string PlayUntilAnError() {
    PlayUntil(
        [this](const swp_link_stats& /*stats*/) { return !Text(SWP_LINK_LAST_ERROR).empty(); });
    return Text(SWP_LINK_LAST_ERROR);
  }

  TemporaryDirectory folder_;
  TemporaryDirectory data_;
  TestAuthority authority_{Path("ca.pem")};
  CertificateFiles server_{Path("server.pem"), Path("server-key.pem")};
  std::string ca_ = authority_.cert();
  std::optional<DaemonProcess> daemon_;
  std::string address_;
  swp_daemon_options options_ = {};
  daemon_game game_ = {};
};

TEST_F(CDaemonTest, ASwitchOfTheDaemonIsExecuted) {
  // "paper" draws at each decision, so a switch does not depend on the measured times.
  daemon_.emplace(data_.path(), "127.0.0.1:0",
                  std::vector<std::string>{"--decision-policy", "paper"});
  StartGame();
  PlayUntil([this](const swp_link_stats& stats) {
    uint32_t epoch = 0;
    EXPECT_EQ(swp_session_switch_epoch(game_.session, &epoch), SWP_OK);
    return stats.command_count > 0 && epoch > 0 && stats.acknowledged_sequence > 0;
  });
  EXPECT_EQ(Text(SWP_LINK_LAST_ERROR), "");
  daemon_game_end(&game_, 60'000);
  EXPECT_EQ(daemon_->Terminate(), 0);
}

TEST_F(CDaemonTest, TlsAndATokenFileAreUsed) {
  const std::string token = CreateToken("ingest");
  StartDaemonWithTls();
  options_.tls = 1;
  options_.ca_file = ca_.c_str();
  options_.token_file = token.c_str();
  StartGame();
  PlayUntil([](const swp_link_stats& stats) { return stats.acknowledged_sequence > 0; });
  EXPECT_EQ(Text(SWP_LINK_LAST_ERROR), "");
}

TEST_F(CDaemonTest, ARefusedTokenIsReportedWithItsReason) {
  CreateToken("ingest");
  daemon_.emplace(data_.path());
  options_.token = "swp_wrong";
  StartGame();
  EXPECT_THAT(PlayUntilRefused(), ::testing::HasSubstr("TOKEN_REFUSED"));
}

TEST_F(CDaemonTest, AMissingTokenIsReportedWithItsReason) {
  CreateToken("ingest");
  daemon_.emplace(data_.path());
  StartGame();
  EXPECT_THAT(PlayUntilRefused(), ::testing::HasSubstr("TOKEN_MISSING"));
}

TEST_F(CDaemonTest, AnUnknownAuthorityIsReportedWithAdvice) {
  const TestAuthority other(Path("other.pem"));
  const std::string other_ca = other.cert();
  StartDaemonWithTls();
  options_.tls = 1;
  options_.ca_file = other_ca.c_str();
  StartGame();
  EXPECT_THAT(PlayUntilAnError(),
              ::testing::HasSubstr("give the certificate of the authority that signed it"));
}

TEST_F(CDaemonTest, APlainTextGameGetsAdviceThatTheDaemonMayRequireTls) {
  StartDaemonWithTls();
  StartGame();
  EXPECT_THAT(PlayUntilAnError(), ::testing::HasSubstr("may require TLS"));
}

TEST_F(CDaemonTest, TheSessionResumesWithADaemonThatWasKilled) {
  daemon_.emplace(data_.path());
  StartGame();
  PlayUntil([](const swp_link_stats& stats) { return stats.acknowledged_sequence > 0; });
  const std::string session = Text(SWP_LINK_SESSION_ID);
  daemon_->Kill();
  PlayUntil([](const swp_link_stats& stats) { return stats.state != SWP_LINK_ONLINE; });
  EXPECT_THAT(Text(SWP_LINK_LAST_ERROR), ::testing::HasSubstr(address_));
  daemon_.emplace(data_.path(), address_);
  PlayUntil([](const swp_link_stats& stats) { return stats.resumed_count > 0; });
  EXPECT_EQ(Text(SWP_LINK_SESSION_ID), session);
  const uint64_t sent = daemon_game_stats(&game_).sent_sequence;
  PlayUntil([sent](const swp_link_stats& stats) { return stats.acknowledged_sequence >= sent; });
}

}  // namespace
}  // namespace sweepstake::test_support
