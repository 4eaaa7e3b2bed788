// Tests the daemon's flag `saving`, which is set while the daemon copies a database whose file was
// removed.
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <memory>
#include <utility>

#include "server/daemon.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::server {
namespace {

// Counts the SQLite connections that are opened while this object lives, as the copy does. Counts
// separately the connections opened while the flag is set, and all others.
class ConnectionsWhileSaving {
 public:
  explicit ConnectionsWhileSaving(std::shared_ptr<const std::atomic<bool>> saving) {
    saving_ = std::move(saving);
    sqlite3_auto_extension(reinterpret_cast<void (*)()>(&Look));
  }
  ~ConnectionsWhileSaving() { sqlite3_reset_auto_extension(); }

  int found_count() const { return found_count_; }
  int missed_count() const { return missed_count_; }

 private:
  static int Look(sqlite3* /*database*/, char** /*error*/, const sqlite3_api_routines* /*api*/) {
    ++(*saving_ ? found_count_ : missed_count_);
    return SQLITE_OK;
  }
  static inline std::shared_ptr<const std::atomic<bool>> saving_;
  static inline std::atomic<int> found_count_ = 0;
  static inline std::atomic<int> missed_count_ = 0;
};

TEST(DaemonSavingTest, TheFlagIsSetOnlyWhileTheCopyIsMade) {
  const test_support::TemporaryDirectory directory;
  Config config;
  config.listen = "127.0.0.1:0";
  config.data = directory.path();
  config.log_level = "off";
  sessions::SteadyLoopClock clock;
  const auto daemon = *Daemon::Start(config, clock);
  const auto saving = daemon->saving();
  EXPECT_FALSE(*saving);
  const ConnectionsWhileSaving connections(saving);
  std::filesystem::remove(directory.path() / "priors.db");
  daemon->Drain(std::chrono::milliseconds(0));
  EXPECT_GT(connections.found_count(), 0);
  EXPECT_EQ(connections.missed_count(), 0);
  EXPECT_FALSE(*saving);
}

}  // namespace
}  // namespace sweepstake::server
