// Tests the bail-out of a game that dies before the next tick. The bail-out reaches the store when
// the session leaves memory, and counts once if the game was only away.
#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::rpc {
namespace {

class LastBailOutTest : public RpcTest {
 protected:
  // Plays a session of one window, with a bail-out in message 2, and cuts its stream. Returns a
  // Hello that resumes the session.
  v1::Hello Dead() {
    v1::Hello hello = OneArmHello();
    {
      TelemetryClient client(channel_);
      Resume(hello, LearnOneWindow(client, hello));
      client.Send(BailOut(2, 5000));
      EXPECT_TRUE(Applied(2));
      client.Cancel();
    }
    EXPECT_TRUE(Eventually([&] { return server_->counters().open_stream_count == 0; }));
    EXPECT_EQ(StoredBailOuts(), 0u);
    return hello;
  }
  uint64_t StoredBailOuts() { return Stored().arms[0].live.bail_out_count; }
  // The game resends what was not acknowledged, and ends its session.
  void ComeBackAndEnd(const v1::Hello& hello, uint64_t acknowledged) {
    TelemetryClient client(channel_);
    const v1::Welcome welcome = client.Open(hello);
    EXPECT_TRUE(welcome.resumed());
    EXPECT_EQ(welcome.acknowledged_sequence(), acknowledged);
    client.Send(BailOut(2, 5000));
    client.Send(Goodbye());
    EXPECT_TRUE(client.Finish().ok());
  }
};

TEST_F(LastBailOutTest, ItReachesTheStoreWhenTheResumeWindowEnds) {
  const v1::Hello hello = Dead();
  clock_.Advance(options_.resume_window_ns);
  ASSERT_TRUE(Eventually([&] { return StoredBailOuts() == 1; }));
  ComeBackAndEnd(hello, 2);
  EXPECT_EQ(StoredBailOuts(), 1u);
}

TEST_F(LastBailOutTest, TheSessionStaysUntilTheBailOutIsOnDisk) {
  Dead();
  store_.Fail(true);
  const uint64_t failed = server_->counters().failed_commit_count;
  clock_.Advance(options_.resume_window_ns);
  ASSERT_TRUE(Eventually([&] { return server_->counters().failed_commit_count > failed; }));
  EXPECT_EQ(server_->counters().session_count, 1u);
  store_.Fail(false);
  const uint64_t stored = server_->counters().stored_commit_count;
  clock_.Advance(2 * kSecondNs);
  ASSERT_TRUE(Eventually([&] { return server_->counters().stored_commit_count > stored; }));
  EXPECT_EQ(StoredBailOuts(), 1u);
  clock_.Advance(2 * kSecondNs);
  EXPECT_TRUE(Eventually([&] { return server_->counters().session_count == 0; }));
}

TEST_F(LastBailOutTest, ItCountsOnceIfTheGameReturnsDuringTheCommit) {
  const v1::Hello hello = Dead();
  store_.Hold();
  clock_.Advance(options_.resume_window_ns);
  ASSERT_TRUE(Eventually([&] { return store_.held_count() == 1; }));
  TelemetryClient client(channel_);
  EXPECT_EQ(client.Open(hello).acknowledged_sequence(), 1u);
  client.Send(BailOut(2, 5000));
  ASSERT_TRUE(Eventually([&] { return server_->counters().replayed_message_count == 1; }));
  store_.Release();
  EXPECT_EQ(client.AwaitAcknowledgement(2), 2u);
  client.Send(Goodbye());
  EXPECT_TRUE(client.Finish().ok());
  EXPECT_EQ(StoredBailOuts(), 1u);
}

TEST_F(LastBailOutTest, ItCountsOnceIfTheGameReturnsInTime) {
  ComeBackAndEnd(Dead(), 1);
  EXPECT_EQ(StoredBailOuts(), 1u);
}

TEST_F(LastBailOutTest, ItCountsOnceIfTheGameReturnsAfterARestart) {
  const v1::Hello hello = Dead();
  RestartServer();
  EXPECT_EQ(StoredBailOuts(), 1u) << "a daemon that stops does not wait for the resume window";
  ComeBackAndEnd(hello, 2);
  EXPECT_EQ(StoredBailOuts(), 1u);
}

class SessionLimitLastBailOutTest : public LastBailOutTest {
 protected:
  SessionLimitLastBailOutTest() { options_.max_sessions = 1; }
};

TEST_F(SessionLimitLastBailOutTest, ItReachesTheStoreWhenTheSessionMakesRoom) {
  const v1::Hello hello = Dead();
  {
    TelemetryClient next(channel_);
    EXPECT_FALSE(next.Open(OneArmHello()).resumed());
    EXPECT_TRUE(Eventually([&] { return StoredBailOuts() == 1; }));
    next.HalfClose();
    EXPECT_TRUE(next.Finish().ok());
  }
  ComeBackAndEnd(hello, 2);
  EXPECT_EQ(StoredBailOuts(), 1u);
}

}  // namespace
}  // namespace sweepstake::rpc
