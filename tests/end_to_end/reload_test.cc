// A configuration that is read again while the daemon runs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/daemon_process.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::test_support {
namespace {

class ReloadTest : public ::testing::Test {
 protected:
  void Write(const std::string& config) {
    std::ofstream(folder_.path() / "sweepstake.toml") << config;
  }
  // Sends SIGHUP and waits until the log has the text.
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

TEST_F(ReloadTest, TheLogLevelIsTakenOverAndWhatIsNotIsNamed) {
  Write("log_level = 'error'\n");
  Start();
  EXPECT_EQ(daemon_->log(), "");
  Write("log_level = 'info'\nmax_sessions = 7\n");
  EXPECT_TRUE(ReloadSays("the configuration was read again; the log level is info"));
  Write("log_level = 'warn'\nmax_sessions = 7\n");
  EXPECT_TRUE(ReloadSays("max_sessions has changed: restart the daemon to take it over"));
  EXPECT_EQ(daemon_->Terminate(), 0);
}

TEST_F(ReloadTest, AWrongConfigurationIsRefusedAndTheDaemonRunsOn) {
  Write("");
  Start();
  Write("lissten = 'x'\n");
  EXPECT_TRUE(ReloadSays("the configuration stays as it is: "));
  EXPECT_THAT(daemon_->log(), ::testing::HasSubstr("lissten"));
  EXPECT_EQ(daemon_->Terminate(), 0);
}

}  // namespace
}  // namespace sweepstake::test_support
