// Tests notifications to the service manager.
#include "server/host/service_manager.h"

#include <gtest/gtest.h>

#include <condition_variable>
#include <mutex>

#include "tests/server/host/notify_socket.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::server {
namespace {

using std::chrono::milliseconds;

// Answers the watchdog's check, and counts its calls.
class Life {
 public:
  bool Ask() {
    const std::lock_guard lock(mutex_);
    ++asked_count_;
    changed_.notify_all();
    return alive_;
  }
  void AwaitQuestions(int count) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return asked_count_ >= count; });
  }
  void Set(bool alive) {
    const std::lock_guard lock(mutex_);
    alive_ = alive;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  int asked_count_ = 0;  // guarded by mutex_
  bool alive_ = false;   // guarded by mutex_
};

TEST(WatchdogTest, NotifiesOnlyWhileTheDaemonIsAlive) {
  const test_support::TemporaryDirectory folder;
  test_support::NotifySocket manager(folder.path(), milliseconds(4));
  Life life;
  EXPECT_EQ(WatchdogInterval(), milliseconds(1)) << "a quarter of the limit";
  const Watchdog watchdog(WatchdogInterval(), [&] { return life.Ask(); });
  life.AwaitQuestions(5);
  EXPECT_EQ(manager.ReceiveNow(), "");
  life.Set(true);
  EXPECT_EQ(manager.Receive(), "WATCHDOG=1");
  EXPECT_EQ(manager.Receive(), "WATCHDOG=1");
  // Keeps the socket empty. If it were full, the watchdog would wait for room in it, and the
  // destructor would wait for the watchdog.
  life.Set(false);
  while (!manager.ReceiveNow().empty()) {
  }
}

TEST(WatchdogTest, DoesNotCheckTheDaemonWithoutAWatchdogInterval) {
  bool asked = false;
  {
    const Watchdog watchdog(WatchdogInterval(), [&] { return asked = true; });
  }
  EXPECT_FALSE(asked);
  NotifyReady();
  NotifyStopping();
}

TEST(ServiceManagerTest, ReceivesReadyStoppingAndTheExtendedTimeout) {
  const test_support::TemporaryDirectory folder;
  test_support::NotifySocket manager(folder.path(), std::chrono::hours(1));
  NotifyReady();
  EXPECT_EQ(manager.Receive(), "READY=1");
  NotifyStopping();
  EXPECT_EQ(manager.Receive(), "STOPPING=1");
  NotifyStoppingTakes(std::chrono::seconds(18));
  EXPECT_EQ(manager.Receive(), "EXTEND_TIMEOUT_USEC=18000000");
}

}  // namespace
}  // namespace sweepstake::server
