// Tests which session a Hello with a session id gets: the named session, or a new one that reveals
// nothing about the named session.
#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::rpc {
namespace {

class ResumeTest : public RpcTest {
 protected:
  // Returns a Hello that resumes a disconnected session of one window.
  v1::Hello Learnt() {
    v1::Hello hello = HelloMessage();
    TelemetryClient client(channel_);
    Resume(hello, LearnOneWindow(client, hello));
    return hello;
  }
  void ExpectNew(const v1::Hello& hello) {
    TelemetryClient client(channel_);
    const v1::Welcome welcome = client.Open(hello);
    EXPECT_FALSE(welcome.resumed());
    EXPECT_NE(welcome.session_id(), hello.session_id());
    EXPECT_EQ(welcome.acknowledged_sequence(), 0u);
  }
  // Tries to resume the session while it is in memory, and again when only the store has it.
  void ExpectNewFromMemoryAndStore(const v1::Hello& hello) {
    ExpectNew(hello);
    RestartServer();
    ExpectNew(hello);
  }
};

TEST_F(ResumeTest, AnUnknownIdBeginsANewSession) {
  v1::Hello hello = HelloMessage();
  hello.set_session_id("0123456789abcdef0123456789abcdef");
  ExpectNew(hello);
}

TEST_F(ResumeTest, AResumedSilentGameStillReceivesTheVerdict) {
  const v1::Hello hello = Learnt();
  TelemetryClient client(channel_);
  EXPECT_TRUE(client.Open(hello).resumed());
  Tick();
  client.Await(&v1::StreamTelemetryResponse::has_posterior_snapshot);
}

TEST_F(ResumeTest, AnIdWithoutItsTokenBeginsANewSession) {
  const v1::Hello hello = Learnt();
  v1::Hello stolen = hello;
  stolen.clear_resume_token();
  ExpectNew(stolen);
  stolen.set_resume_token(std::string(32, 'x'));
  ExpectNewFromMemoryAndStore(stolen);
  EXPECT_TRUE(TelemetryClient(channel_).Open(hello).resumed())
      << "the session's own client can still resume it";
}

TEST_F(ResumeTest, TheTokenOfAnotherSessionIsRefused) {
  v1::Hello hello = Learnt();
  hello.set_resume_token(TelemetryClient(channel_).Open(HelloMessage()).resume_token());
  ExpectNewFromMemoryAndStore(hello);
}

TEST_F(ResumeTest, AnotherSceneBeginsANewSession) {
  v1::Hello hello = Learnt();
  hello.set_scene("desert");
  ExpectNewFromMemoryAndStore(hello);
}

TEST_F(ResumeTest, AnotherMachineClassBeginsANewSession) {
  v1::Hello hello = Learnt();
  hello.set_machine_class("a faster one");
  ExpectNewFromMemoryAndStore(hello);
}

TEST_F(ResumeTest, AnotherVersionOfAnArmBeginsANewSession) {
  v1::Hello hello = Learnt();
  hello.mutable_arms(0)->set_backend_version(2);
  ExpectNewFromMemoryAndStore(hello);
}

TEST_F(ResumeTest, ASessionThatEndedAndWaitsForTheDiskIsNotResumed) {
  v1::Hello hello = HelloMessage();
  {
    TelemetryClient client(channel_);
    Resume(hello, LearnOneWindow(client, hello));
    client.Send(Frames(2, 30));
    ASSERT_TRUE(Applied(2));
    store_.Fail(true);
    client.Send(Goodbye());
    client.Finish();
  }
  ExpectNew(hello);
}

TEST_F(ResumeTest, TheNewSessionLearnsIndependentlyOfTheOldOne) {
  v1::Hello hello = Learnt();
  hello.set_machine_class("a faster one");
  TelemetryClient client(channel_);
  client.Open(hello);
  client.Send(Frames(1, 30));
  ASSERT_TRUE(Applied(2));
  Tick();
  EXPECT_EQ(client.AwaitAcknowledgement(1), 1u);
  EXPECT_EQ(Stored().arms[0].live.window_count, 1u);
}

}  // namespace
}  // namespace sweepstake::rpc
