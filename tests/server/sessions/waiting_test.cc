// Updates that wait for an unavailable store are passed to the function that keeps them. Each is
// passed exactly once.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <mutex>
#include <string>
#include <vector>

#include "engine_client/decider/audit/audit_log.h"
#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::rpc {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

class StoreOutageTest : public RpcTest {
 protected:
  StoreOutageTest() {
    options_.keep_waiting = [this](std::vector<priors::SourceUpdate> updates) {
      const std::lock_guard lock(mutex_);
      kept_ = std::move(updates);
      ++kept_count_;
    };
  }
  uint64_t kept_count() {
    const std::lock_guard lock(mutex_);
    return kept_count_;
  }
  std::vector<priors::SourceUpdate> kept() {
    const std::lock_guard lock(mutex_);
    return kept_;
  }
  // Advances one second, and waits until the server has run the timers that are due. Timers run
  // after the tasks of the same turn. Therefore only the second call returns after them.
  void PassSecond() {
    clock_.Advance(kSecondNs);
    server_->CountHeld();
    server_->CountHeld();
  }
  // Advances the clock until the server has passed on its waiting updates once.
  void Keep() {
    const uint64_t before = kept_count();
    for (int second = 0; second < 20 && kept_count() == before; ++second) PassSecond();
    ASSERT_GT(kept_count(), before);
  }
  // Commits directly to the store, as a daemon does at its start.
  void Deliver(const std::vector<priors::SourceUpdate>& updates) {
    thread_.Submit([&](priors::PriorStore& store) {
      for (const priors::SourceUpdate& update : updates)
        EXPECT_TRUE(store.Commit({&update, 1}).ok());
    });
    Flush();
  }

  std::mutex mutex_;
  std::vector<priors::SourceUpdate> kept_;  // guarded by mutex_
  uint64_t kept_count_ = 0;                 // guarded by mutex_
};

TEST_F(StoreOutageTest, EvidenceOfAnHourIsKeptAndCountsOnce) {
  constexpr uint64_t kMinutes = 60;
  v1::Hello hello = OneArmHello();
  {
    TelemetryClient client(channel_);
    Resume(hello, LearnOneWindow(client, hello));
    store_.Fail(true);
    for (uint64_t message = 2; message <= 1 + kMinutes; ++message) {
      client.Send(Frames(message, 30));
      ASSERT_TRUE(Applied(message));
      const uint64_t decisions = server_->counters().decision_count;
      clock_.Advance(60 * kSecondNs);
      ASSERT_TRUE(Eventually([&] { return server_->counters().decision_count > decisions; }));
    }
    Keep();
  }
  const std::vector<priors::SourceUpdate> before_the_end = kept();
  StopServer();
  store_.Fail(false);
  EXPECT_EQ(Stored().arms[0].live.window_count, 1u) << "the kept hour is not delivered yet";
  Deliver(before_the_end);
  EXPECT_EQ(Stored().arms[0].live.window_count, 1 + kMinutes);
  Deliver(before_the_end);
  EXPECT_EQ(Stored().arms[0].live.window_count, 1 + kMinutes) << "once";
  StartServer();
  TelemetryClient client(channel_);
  EXPECT_EQ(client.Open(hello).acknowledged_sequence(), 1 + kMinutes);
}

TEST_F(StoreOutageTest, KeepsTheEvidenceOfAnEndedSessionAtShutdown) {
  TelemetryClient client(channel_);
  LearnOneWindow(client, OneArmHello());
  store_.Fail(true);
  client.Send(Frames(2, 30));
  ASSERT_TRUE(Applied(2));
  Tick();
  ASSERT_TRUE(Eventually([&] { return server_->counters().failed_commit_count > 0; }));
  client.Send(Goodbye());
  client.HalfClose();
  ASSERT_TRUE(Eventually([&] { return server_->CountHeld().ended_session_count == 1; }));
  StopServer();
  store_.Fail(false);
  Deliver(kept());
  EXPECT_EQ(Stored().arms[0].live.window_count, 2u);
}

TEST_F(StoreOutageTest, KeepsActionsOfAdministratorsDuringTheOutage) {
  server_->RecordAction("", "one from before");
  ASSERT_TRUE(Eventually([&] {
    bool is_stored = false;
    thread_.Submit([&](priors::PriorStore& store) {
      is_stored = store.LoadSource(std::string(decision::kAdminSession))->has_value();
    });
    Flush();
    return is_stored;
  }));
  store_.Fail(true);
  server_->RecordAction("", "one from meanwhile");
  Keep();
  std::string rows;
  for (const priors::SourceUpdate& update : kept()) {
    for (const priors::StoredAuditRow& row : update.audit.rows) rows += row.bytes;
  }
  EXPECT_THAT(rows, HasSubstr("one from meanwhile"));
  EXPECT_THAT(rows, Not(HasSubstr("one from before")));
}

TEST_F(StoreOutageTest, KeepsNothingBeforeAndAfterTheOutage) {
  TelemetryClient client(channel_);
  LearnOneWindow(client, OneArmHello());
  for (int second = 0; second < 20; ++second) PassSecond();
  EXPECT_EQ(kept_count(), 0u);
  store_.Fail(true);
  client.Send(Frames(2, 30));
  ASSERT_TRUE(Applied(2));
  Tick();
  Keep();
  store_.Fail(false);
  Tick();
  client.AwaitAcknowledgement(2);
  Keep();
  EXPECT_THAT(kept(), IsEmpty());
}

}  // namespace
}  // namespace sweepstake::rpc
