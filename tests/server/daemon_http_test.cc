// Tests the daemon's pages for operators, in each of their states.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <mutex>
#include <optional>
#include <string>

#include "server/auth/token_store.h"
#include "server/daemon.h"
#include "server/storage/backup/sqlite_backup.h"
#include "tests/support/http_exchange.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::server {
namespace {

using test_support::Get;
using ::testing::AllOf;
using ::testing::HasSubstr;

// A clock whose loop can be made to hang.
class HangingClock final : public sessions::LoopClock {
 public:
  int64_t NowNs() const override { return steady_.NowNs() + ahead_ns_; }
  void WaitUntil(int64_t deadline_ns) override {
    {
      std::unique_lock lock(mutex_);
      waiting_ = true;
      changed_.notify_all();
      changed_.wait(lock, [this] { return !hangs_; });
      waiting_ = false;
    }
    steady_.WaitUntil(deadline_ns - ahead_ns_);
  }
  void Wake() override { steady_.Wake(); }
  // Makes the loop hang, and then advances the clock by `duration_ns`.
  void HangFor(int64_t duration_ns) {
    std::unique_lock lock(mutex_);
    hangs_ = true;
    steady_.Wake();
    changed_.wait(lock, [this] { return waiting_; });
    ahead_ns_ += duration_ns;
  }
  void Release() {
    const std::lock_guard lock(mutex_);
    hangs_ = false;
    changed_.notify_all();
  }

 private:
  sessions::SteadyLoopClock steady_;
  std::atomic<int64_t> ahead_ns_ = 0;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool hangs_ = false;    // guarded by mutex_
  bool waiting_ = false;  // guarded by mutex_; the loop waits for the end of hanging
};

class DaemonHttpTest : public ::testing::Test {
 protected:
  DaemonHttpTest() {
    config_.listen = "127.0.0.1:0";
    config_.http = "127.0.0.1:0";
    config_.data = directory_.path() / "data";
    config_.port_file = directory_.path() / "port";
    config_.log_level = "off";
  }
  std::unique_ptr<Daemon> Start() {
    auto daemon = Daemon::Start(config_, clock_);
    EXPECT_TRUE(daemon.ok()) << daemon.status();
    return *std::move(daemon);
  }
  std::string PortFile() {
    std::ifstream file(config_.port_file);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  test_support::TemporaryDirectory directory_;
  Config config_;
  sessions::SteadyLoopClock clock_;
};

TEST_F(DaemonHttpTest, ThePortFilesSecondLineIsTheHttpPort) {
  const auto daemon = Start();
  EXPECT_EQ(PortFile(),
            std::to_string(daemon->port()) + "\n" + std::to_string(daemon->http_port()) + "\n");
}

TEST_F(DaemonHttpTest, WithoutTheSettingThereIsNoHttpPort) {
  config_.http.clear();
  const auto daemon = Start();
  EXPECT_EQ(PortFile(), std::to_string(daemon->port()) + "\n");
}

TEST_F(DaemonHttpTest, AnHttpPortInUseStopsTheStart) {
  const auto daemon = Start();
  config_.http = "127.0.0.1:" + std::to_string(daemon->http_port());
  config_.data = directory_.path() / "other";
  sessions::SteadyLoopClock clock;
  EXPECT_TRUE(absl::IsUnavailable(Daemon::Start(config_, clock).status()));
}

TEST_F(DaemonHttpTest, ARunningDaemonIsLiveAndReady) {
  const auto daemon = Start();
  EXPECT_EQ(Get(daemon->http_port(), "/livez").status, 200);
  EXPECT_EQ(Get(daemon->http_port(), "/readyz?verbose").body,
            "[+]decision-loop ok\n[+]store ok\n[+]tls ok\n[+]shutdown ok\nreadyz check passed\n");
}

TEST_F(DaemonHttpTest, ADrainedDaemonIsLiveAndNotReady) {
  const auto daemon = Start();
  daemon->Drain();
  EXPECT_EQ(Get(daemon->http_port(), "/livez").status, 200);
  const auto ready = Get(daemon->http_port(), "/readyz");
  EXPECT_EQ(ready.status, 503);
  EXPECT_THAT(ready.body, HasSubstr("[-]shutdown failed: the daemon is draining\n"));
}

TEST_F(DaemonHttpTest, ADaemonThatDoesNotDecideIsNeitherLiveNorReady) {
  HangingClock clock;
  const auto daemon = Daemon::Start(config_, clock);
  ASSERT_TRUE(daemon.ok());
  clock.HangFor(60'000'000'000);
  const auto live = Get((*daemon)->http_port(), "/livez");
  EXPECT_EQ(live.status, 503);
  EXPECT_THAT(live.body, HasSubstr("[-]decision-loop failed"));
  EXPECT_EQ(Get((*daemon)->http_port(), "/readyz").status, 503);
  clock.Release();
}

TEST_F(DaemonHttpTest, ADaemonWithADamagedDatabaseUsesABackupAndReportsIt) {
  Start();
  const auto database = config_.data / "priors.db";
  ASSERT_TRUE(
      storage::BackUpStore(config_.data, database.string() + ".backup-20260101T000000Z").ok());
  std::filesystem::resize_file(database, 0);
  const auto daemon = Start();
  const auto ready = Get(daemon->http_port(), "/readyz?verbose");
  EXPECT_EQ(ready.status, 200);
  EXPECT_THAT(ready.body, HasSubstr("[+]store ok, but " + database.string()));
  EXPECT_THAT(ready.body, HasSubstr("priors.db.backup-20260101T000000Z replaces it"));
  EXPECT_THAT(Get(daemon->http_port(), "/metrics").body, HasSubstr("sweepstake_store_damaged 1\n"));
}

TEST_F(DaemonHttpTest, MetricsShowTheStateOfTheDaemon) {
  const auto daemon = Start();
  const auto answer = Get(daemon->http_port(), "/metrics");
  EXPECT_EQ(answer.status, 200);
  EXPECT_THAT(answer.head, HasSubstr("Content-Type: text/plain; version=0.0.4"));
  EXPECT_THAT(
      answer.body,
      AllOf(HasSubstr("sweepstake_build_info{version=\"" SWEEPSTAKE_VERSION "\"} 1\n"),
            HasSubstr("sweepstake_store_healthy 1\n"), HasSubstr("sweepstake_store_damaged 0\n"),
            HasSubstr("sweepstake_store_last_backup_timestamp_seconds 0\n"),
            HasSubstr("sweepstake_open_streams 0\n")));
}

// Logs in, and returns the cookie.
std::string CookieFor(const std::string& token, int port) {
  const std::string body = "{\"token\":\"" + token + "\"}";
  const std::string head =
      test_support::Exchange(port,
                             "POST /login HTTP/1.1\r\nHost: localhost\r\nX-Sweepstake: 1\r\n"
                             "Connection: close\r\nContent-Length: " +
                                 std::to_string(body.size()) + "\r\n\r\n" + body)
          .head;
  const size_t start = head.find("sweepstake=");
  return start == std::string::npos ? "" : head.substr(start, head.find(';', start) - start);
}

std::string WhoAmI(const std::string& cookie, int port) {
  return test_support::Exchange(port, "GET /api/whoami HTTP/1.1\r\nHost: localhost\r\nCookie: " +
                                          cookie + "\r\nConnection: close\r\n\r\n")
      .body;
}

class DaemonLoginTest : public DaemonHttpTest {
 protected:
  DaemonLoginTest() {
    std::filesystem::create_directory(config_.data);
    token_ = auth::TokenStore::Open(config_.data / "tokens.db")
                 .value()
                 .Create({.name = "ann",
                          .role = auth::Role::kWatch,
                          .projects = {},
                          .expires_unix_s = std::nullopt,
                          .made_by = "the test"},
                         1)
                 .value();
  }

  std::string token_;
};

TEST_F(DaemonLoginTest, ALoginEndsWithTheDaemon) {
  auto daemon = Start();
  const std::string cookie = CookieFor(token_, daemon->http_port());
  ASSERT_THAT(WhoAmI(cookie, daemon->http_port()), HasSubstr(R"("loggedIn":true,"name":"ann")"));
  EXPECT_THAT(WhoAmI(cookie.substr(0, cookie.size() - 1), daemon->http_port()),
              HasSubstr(R"("loggedIn":false)"));
  daemon.reset();
  daemon = Start();
  EXPECT_THAT(WhoAmI(cookie, daemon->http_port()), HasSubstr(R"("loggedIn":false)"));
}

}  // namespace
}  // namespace sweepstake::server
