// Tests evidence that is not on disk yet when its client leaves: after a goodbye, a half-close, a
// lost connection, a drain, and with a full table.
#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::rpc {
namespace {

using Response = v1::StreamTelemetryResponse;

class GoodbyeTest : public RpcTest {
 protected:
  // Expects the refusal of a goodbye while the disk is full.
  static void ExpectRefusal(TelemetryClient& client) {
    const grpc::Status status = client.Finish();
    EXPECT_EQ(status.error_code(), grpc::StatusCode::UNAVAILABLE);
    EXPECT_THAT(status.error_message(), ::testing::HasSubstr("the disk is full"));
    EXPECT_THAT(status.error_message(), ::testing::HasSubstr("tries again"));
  }
  // Opens a session with one applied message that is not on disk.
  v1::Welcome OpenWithEvidence(TelemetryClient& client) {
    const uint64_t message_count = server_->counters().applied_message_count;
    const v1::Welcome welcome = client.Open(OneArmHello());
    client.Send(Frames(1, 30));
    EXPECT_TRUE(Applied(message_count + 1));
    return welcome;
  }
  [[nodiscard]] bool Held(size_t count) {
    return Eventually([&] { return store_.held_count() == count; });
  }
  // Opens a session with two applied messages, and says goodbye while the commit of the first is
  // held. Returns its id.
  std::string SayGoodbyeBehindACommit(TelemetryClient& client) {
    const std::string id = OpenWithEvidence(client).session_id();
    store_.Hold();
    Tick();
    EXPECT_TRUE(Held(1));
    client.Send(Frames(2, 30));
    client.Send(Goodbye());
    return id;
  }
  // Returns the stored frame count of the session.
  uint64_t StoredFrames(const std::string& session_id) {
    std::promise<uint64_t> frames;
    thread_.Submit([&](priors::PriorStore& store) {
      const auto source = *store.LoadSource(session_id);
      frames.set_value(source ? source->progress.frame_count : 0);
    });
    return frames.get_future().get();
  }
  [[nodiscard]] bool ReachesTheStore(const std::string& session_id, uint64_t frame_count = 30) {
    return Eventually([&] { return StoredFrames(session_id) == frame_count; });
  }
};

TEST_F(GoodbyeTest, AHalfCloseAfterAGoodbyeLeavesTheStreamOpenUntilTheCommit) {
  TelemetryClient client(channel_);
  const std::string id = OpenWithEvidence(client).session_id();
  store_.Hold();
  client.Send(Goodbye());
  client.HalfClose();
  ASSERT_TRUE(Held(1));
  // If the stream had ended with the half-close, there would be no acknowledgement.
  store_.Release();
  EXPECT_EQ(client.AwaitAcknowledgement(1), 1u);
  EXPECT_TRUE(client.Finish().ok());
  EXPECT_EQ(StoredFrames(id), 30u);
}

TEST_F(GoodbyeTest, AGoodbyeWaitsForAQueuedCommit) {
  TelemetryClient client(channel_);
  const std::string id = SayGoodbyeBehindACommit(client);
  client.HalfClose();
  ASSERT_TRUE(Applied(2));
  store_.Release();
  EXPECT_EQ(client.AwaitAcknowledgement(2), 2u);
  EXPECT_TRUE(client.Finish().ok());
  EXPECT_EQ(StoredFrames(id), 60u);
}

TEST_F(GoodbyeTest, AfterALostConnectionTheCommitStillReachesTheStore) {
  TelemetryClient client(channel_);
  const std::string id = SayGoodbyeBehindACommit(client);
  ASSERT_TRUE(Eventually([&] { return server_->counters().goodbye_count == 1; }));
  client.Cancel();
  EXPECT_EQ(client.Finish().error_code(), grpc::StatusCode::CANCELLED);
  ASSERT_TRUE(Eventually([&] { return server_->counters().open_stream_count == 0; }));
  store_.Release();
  EXPECT_TRUE(ReachesTheStore(id, 60));
}

TEST_F(GoodbyeTest, EvidenceThatTheDiskRefusedIsOfferedAgainWithoutAClient) {
  TelemetryClient client(channel_);
  const std::string id = OpenWithEvidence(client).session_id();
  store_.Fail(true);
  client.Send(Goodbye());
  ExpectRefusal(client);
  EXPECT_EQ(StoredFrames(id), 0u);
  store_.Fail(false);
  clock_.Advance(2 * kSecondNs);
  EXPECT_TRUE(ReachesTheStore(id));
}

TEST_F(GoodbyeTest, ADrainRetriesRefusedEvidenceAndWaitsForIt) {
  TelemetryClient client(channel_);
  const std::string id = OpenWithEvidence(client).session_id();
  store_.Fail(true);
  client.Send(Goodbye());
  ExpectRefusal(client);
  store_.Fail(false);
  server_->Drain(std::chrono::minutes(10));
  EXPECT_EQ(StoredFrames(id), 30u);
}

TEST_F(GoodbyeTest, ADrainWithAFailingDiskReleasesClientsAtOnce) {
  TelemetryClient client(channel_);
  OpenWithEvidence(client);
  store_.Fail(true);
  const uint64_t failed = server_->counters().failed_commit_count;
  Tick();
  ASSERT_TRUE(Eventually([&] { return server_->counters().failed_commit_count == failed + 1; }));
  // The drain must not wait for this deadline, which is longer than the time limit of the test.
  server_->Drain(std::chrono::minutes(10));
  EXPECT_EQ(client.Finish().error_code(), grpc::StatusCode::UNAVAILABLE);
}

TEST_F(GoodbyeTest, AfterADrainCountHeldReportsEvidenceThatTheDiskRefused) {
  TelemetryClient stored(channel_);
  LearnOneWindow(stored, OneArmHello());
  TelemetryClient ended(channel_);
  OpenWithEvidence(ended);
  TelemetryClient back_later(channel_);
  OpenWithEvidence(back_later);
  store_.Fail(true);
  const uint64_t failed = server_->counters().failed_commit_count;
  Tick();
  ASSERT_TRUE(Eventually([&] { return server_->counters().failed_commit_count == failed + 2; }));
  ended.Send(Goodbye());
  ExpectRefusal(ended);
  server_->Drain(std::chrono::minutes(10));
  const sessions::HeldEvidence held = server_->CountHeld();
  EXPECT_EQ(held.session_count, 2u);
  EXPECT_EQ(held.ended_session_count, 1u);
}

TEST_F(GoodbyeTest, AMessageAfterAGoodbyeIsNotEvidence) {
  TelemetryClient client(channel_);
  const std::string id = OpenWithEvidence(client).session_id();
  store_.Hold();
  client.Send(Goodbye());
  client.Send(Frames(2, 30));
  ASSERT_TRUE(Held(1));
  store_.Release();
  EXPECT_EQ(client.AwaitAcknowledgement(1), 1u);
  EXPECT_TRUE(client.Finish().ok());
  EXPECT_EQ(server_->counters().applied_message_count, 1u);
  EXPECT_EQ(StoredFrames(id), 30u);
}

class SessionLimitGoodbyeTest : public GoodbyeTest {
 protected:
  SessionLimitGoodbyeTest() { options_.max_sessions = 1; }
};

TEST_F(SessionLimitGoodbyeTest, AnEndedSessionWithUnstoredEvidenceStays) {
  std::string id;
  {
    TelemetryClient client(channel_);
    id = OpenWithEvidence(client).session_id();
    store_.Fail(true);
    client.Send(Goodbye());
    ExpectRefusal(client);
  }
  TelemetryClient second(channel_);
  second.Send(Request(OneArmHello()));
  EXPECT_EQ(second.Finish().error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  store_.Fail(false);
  clock_.Advance(2 * kSecondNs);
  ASSERT_TRUE(Eventually([&] { return server_->counters().stored_commit_count == 1; }));
  EXPECT_EQ(StoredFrames(id), 30u);
  TelemetryClient third(channel_);
  EXPECT_FALSE(third.Open(OneArmHello()).resumed());
}

TEST_F(SessionLimitGoodbyeTest, AResumedSessionWithUnstoredEvidenceMakesNoRoom) {
  v1::Hello hello = OneArmHello();
  store_.Fail(true);
  {
    TelemetryClient client(channel_);
    Resume(hello, OpenWithEvidence(client));
    const uint64_t failed = server_->counters().failed_commit_count;
    Tick();
    ASSERT_TRUE(Eventually([&] { return server_->counters().failed_commit_count > failed; }));
    client.HalfClose();
    EXPECT_TRUE(client.Finish().ok());
  }
  TelemetryClient client(channel_);
  ASSERT_TRUE(client.Open(hello).resumed());
  TelemetryClient second(channel_);
  second.Send(Request(OneArmHello()));
  EXPECT_EQ(second.Finish().error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
}

TEST_F(SessionLimitGoodbyeTest, ALostSessionMakesRoomBecauseItsClientResendsUnstoredEvidence) {
  v1::Hello hello = OneArmHello();
  {
    TelemetryClient client(channel_);
    Resume(hello, LearnOneWindow(client, hello));
    client.Send(Frames(2, 30));
    ASSERT_TRUE(Applied(2));
    store_.Fail(true);
    const uint64_t failed = server_->counters().failed_commit_count;
    Tick();
    ASSERT_TRUE(Eventually([&] { return server_->counters().failed_commit_count > failed; }));
    client.HalfClose();
    EXPECT_TRUE(client.Finish().ok());
  }
  store_.Fail(false);
  {
    TelemetryClient second(channel_);
    second.Open(OneArmHello());
    second.HalfClose();
    EXPECT_TRUE(second.Finish().ok());
  }
  TelemetryClient client(channel_);
  const v1::Welcome welcome = client.Open(hello);
  EXPECT_TRUE(welcome.resumed());
  EXPECT_EQ(welcome.acknowledged_sequence(), 1u);
  client.Send(Frames(2, 30));
  client.Send(Goodbye());
  EXPECT_EQ(client.AwaitAcknowledgement(2), 2u);
  EXPECT_EQ(StoredFrames(hello.session_id()), 60u);
}

}  // namespace
}  // namespace sweepstake::rpc
