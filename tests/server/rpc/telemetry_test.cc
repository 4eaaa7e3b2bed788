// The stream of telemetry: sessions, evidence, acknowledgements.
#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::rpc {
namespace {

using Response = v1::StreamTelemetryResponse;
using ::testing::HasSubstr;

class TelemetryTest : public RpcTest {};

TEST_F(TelemetryTest, HelloIsAnsweredWithAWelcomeThatSaysHowToGoOn) {
  TelemetryClient client(channel_);
  const v1::Welcome welcome = client.Open(HelloMessage());
  EXPECT_EQ(welcome.session_id().size(), 32u);
  EXPECT_FALSE(welcome.resumed());
  EXPECT_EQ(welcome.acknowledged_sequence(), 0u);
  EXPECT_EQ(welcome.max_batch_frames(), 240u);
  EXPECT_EQ(welcome.max_message_bytes(), 256u * 1024);
  EXPECT_EQ(welcome.batch_interval_ms(), 250u);
  EXPECT_EQ(welcome.decision_interval_ms(), 2000u);
  EXPECT_EQ(welcome.cooldown_ms(), 40'000u);
  EXPECT_EQ(welcome.bail_out_ms(), 5000u);
  EXPECT_EQ(welcome.resume_window_ms(), 600'000u);
  EXPECT_EQ(welcome.policy(), "paper");
  EXPECT_EQ(welcome.reward_version(), 1u);
  EXPECT_EQ(welcome.seed(), 7u);
  ASSERT_EQ(welcome.priors_size(), 3);
  EXPECT_EQ(welcome.priors(2).alpha(), 1);
  EXPECT_EQ(welcome.priors(2).beta(), 1);
  EXPECT_EQ(welcome.prior_source_count(), 0u);
}

TEST_F(TelemetryTest, TheTimeScaleDividesTheIntervalsOfTheWelcome) {
  TelemetryClient client(channel_);
  v1::Hello hello = HelloMessage();
  hello.set_time_scale(100);
  const v1::Welcome welcome = client.Open(hello);
  EXPECT_EQ(welcome.decision_interval_ms(), 20u);
  EXPECT_EQ(welcome.cooldown_ms(), 400u);
  EXPECT_EQ(welcome.bail_out_ms(), 5000u);
  EXPECT_EQ(welcome.batch_interval_ms(), 2u);
}

TEST_F(TelemetryTest, ATickTurnsFramesIntoASnapshotAndAnAcknowledgement) {
  TelemetryClient client(channel_);
  client.Open(HelloMessage());
  client.Send(Frames(1, 30));
  ASSERT_TRUE(Applied(1));
  Tick();
  const v1::PosteriorSnapshot snapshot =
      client.Await(Response::kPosteriorSnapshot).posterior_snapshot();
  ASSERT_EQ(snapshot.arms_size(), 3);
  EXPECT_NEAR(snapshot.arms(0).alpha() + snapshot.arms(0).beta(), 3, 1e-12);
  EXPECT_EQ(snapshot.arms(1).alpha() + snapshot.arms(1).beta(), 2);
  EXPECT_EQ(client.AwaitAcknowledgement(1), 1u);
  ASSERT_EQ(Stored().arms.size(), 1u);
  EXPECT_EQ(Stored().arms[0].name, "Grid");
  EXPECT_EQ(Stored().arms[0].evidence.window_count, 1u);
}

}  // namespace
}  // namespace sweepstake::rpc
