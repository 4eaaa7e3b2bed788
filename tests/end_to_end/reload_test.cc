// Tests that a running daemon reads its configuration again.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/end_to_end/scripted_game.h"
#include "tests/support/daemon_process.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::test_support {
namespace {

class ReloadTest : public ::testing::Test {
 protected:
  void Write(const std::string& config) {
    std::ofstream(folder_.path() / "sweepstake.toml") << config;
  }
  // Sends SIGHUP and waits until the log contains the text.
  bool ReloadSays(const std::string& text) {
    kill(daemon_->pid(), SIGHUP);
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (daemon_->log().find(text) == std::string::npos) {
      if (std::chrono::steady_clock::now() > deadline) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return true;
  }
  void Start() {
    daemon_ = std::make_unique<DaemonProcess>(
        data_.path(), "127.0.0.1:0",
        std::vector<std::string>{"--config", folder_.path() / "sweepstake.toml"});
  }

  TemporaryDirectory data_;
  TemporaryDirectory folder_;
  std::unique_ptr<DaemonProcess> daemon_;
};

TEST_F(ReloadTest, TheLogLevelIsAppliedAndFixedSettingsAreNamed) {
  Write("log_level = 'error'\n");
  Start();
  EXPECT_EQ(daemon_->log(), "");
  Write("log_level = 'info'\nmemory_quota_mb = 70\n");
  EXPECT_TRUE(ReloadSays("read the configuration again; the log level is info"));
  Write("log_level = 'warn'\nmemory_quota_mb = 70\n");
  EXPECT_TRUE(ReloadSays("memory_quota_mb has changed; restart the daemon to apply it"));
  EXPECT_EQ(daemon_->Terminate(), 0);
}

TEST_F(ReloadTest, QuotasRatesBoundsAndBackupsAreApplied) {
  Write("");
  Start();
  Write("max_scenes = 1\nmax_reads_per_s = 5\nbackup_hours = 2\naudit_mb = 8\naudit_days = 7\n");
  EXPECT_TRUE(
      ReloadSays("applied: max_scenes, max_reads_per_s, backup_hours, audit_mb, audit_days"));
  EXPECT_THAT(daemon_->log(), ::testing::Not(::testing::HasSubstr("restart the daemon")));
  ScriptedGame first(daemon_->address(), FastOptions());
  EXPECT_TRUE(first.RunUntil(IsConnected));
  SessionOptions options = FastOptions();
  options.scene = "another scene";
  ScriptedGame second(daemon_->address(), options);
  EXPECT_TRUE(second.RunUntil([](const SessionStats& stats) {
    return stats.last_error.find("TOO_MANY_SCENES") != std::string::npos;
  }));
  Write("max_scenes = 2\n");
  kill(daemon_->pid(), SIGHUP);
  EXPECT_TRUE(second.RunUntil(IsConnected, UINT64_MAX));
  EXPECT_EQ(daemon_->Terminate(), 0);
}

TEST_F(ReloadTest, AnInvalidConfigurationIsRefusedAndTheDaemonContinues) {
  Write("");
  Start();
  Write("lissten = 'x'\n");
  EXPECT_TRUE(ReloadSays("the configuration is invalid and was not applied: "));
  EXPECT_THAT(daemon_->log(), ::testing::HasSubstr("lissten"));
  EXPECT_EQ(daemon_->Terminate(), 0);
}

}  // namespace
}  // namespace sweepstake::test_support
