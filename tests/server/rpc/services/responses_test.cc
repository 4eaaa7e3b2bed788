// Tests responses to a game: their content, the time at which they are sent, and what one response
// combines.
#include <memory>
#include <optional>
#include <vector>

#include "tests/server/rpc/rpc_test_fixture.h"
#include "tests/server/rpc/services/prompt_daemon.h"

namespace sweepstake::rpc {
namespace {

using Response = v1::StreamTelemetryResponse;

class ResponseTest : public RpcTest {};

TEST_F(ResponseTest, AnAcknowledgementHasTheBatchIntervalForTheCurrentNumberOfStreams) {
  StopServer();
  options_.max_time_scale = 100;
  StartServer();
  v1::Hello hello = HelloMessage();
  hello.set_time_scale(100);
  TelemetryClient first(channel_);
  EXPECT_EQ(first.Open(hello).batch_interval_ms(), 2u);
  std::vector<std::unique_ptr<TelemetryClient>> others;
  while (others.size() < 39) {
    others.push_back(std::make_unique<TelemetryClient>(channel_));
    others.back()->Open(hello);
  }
  for (const uint32_t expected : {4u, 0u}) {
    first.Send(Frames(expected == 4 ? 1 : 2, 30));
    ASSERT_TRUE(Applied(expected == 4 ? 1 : 2));
    Tick();
    EXPECT_EQ(first.Await(&Response::has_acknowledgement).acknowledgement().batch_interval_ms(),
              expected)
        << "0 if the interval is unchanged";
  }
}

TEST_F(ResponseTest, ATickSendsASnapshotAndAnAcknowledgement) {
  TelemetryClient client(channel_);
  client.Open(HelloMessage());
  client.Send(Frames(1, 30));
  ASSERT_TRUE(Applied(1));
  Tick();
  const v1::PosteriorSnapshot snapshot =
      client.Await(&Response::has_posterior_snapshot).posterior_snapshot();
  ASSERT_EQ(snapshot.arms_size(), 3);
  EXPECT_NEAR(snapshot.arms(0).alpha() + snapshot.arms(0).beta(), 3, 1e-12);
  EXPECT_EQ(snapshot.arms(1).alpha() + snapshot.arms(1).beta(), 2);
  ASSERT_EQ(snapshot.standings_size(), 3);
  EXPECT_EQ(snapshot.standings(0).live_window_count(), 1u);
  EXPECT_NEAR(snapshot.standings(0).effective_window_count(), 1, 1e-12);
  EXPECT_EQ(snapshot.standings(1).effective_window_count(), 0);
  EXPECT_EQ(snapshot.standings(static_cast<int>(snapshot.leader_arm())).best_probability(),
            snapshot.leader_probability());
  EXPECT_FALSE(snapshot.standings(0).has_cost_ratio())
      << "the reward of the policy paper has no costs";
  EXPECT_EQ(client.AwaitAcknowledgement(1), 1u);
  ASSERT_EQ(Stored().arms.size(), 1u);
  EXPECT_EQ(Stored().arms[0].name, "Grid");
  EXPECT_EQ(Stored().arms[0].live.window_count, 1u);
}

TEST_F(ResponseTest, AnAcknowledgementAndThePosteriorsAreOneResponse) {
  PromptDaemon daemon(options_);
  PromptStream stream(daemon);
  ASSERT_TRUE(stream.Send(Request(OneArmHello())));
  ASSERT_TRUE(stream.Send(Frames(1, 30)));
  daemon.Advance(options_.decision.decision_interval_ns);
  ASSERT_EQ(stream.written().size(), 2u);
  EXPECT_TRUE(stream.written()[1].has_acknowledgement());
  EXPECT_TRUE(stream.written()[1].has_posterior_snapshot());
}

TEST_F(ResponseTest, ASnapshotHasTheVerdictAndTheLeader) {
  TelemetryClient client(channel_);
  client.Open(OneArmHello());
  client.Send(Frames(1, 30));
  ASSERT_TRUE(Applied(1));
  Tick();
  const v1::PosteriorSnapshot snapshot =
      client.Await(&Response::has_posterior_snapshot).posterior_snapshot();
  EXPECT_EQ(snapshot.verdict(), v1::VERDICT_STABLE);
  EXPECT_EQ(snapshot.leader_arm(), 0u);
  EXPECT_EQ(snapshot.leader_probability(), 1);
}

TEST_F(ResponseTest, AChangedVerdictIsSentEvenWithoutNewEvidence) {
  TelemetryClient client(channel_);
  client.Open(OneArmHello());
  client.Send(Frames(1, 30));
  ASSERT_TRUE(Applied(1));
  Tick();
  client.Await(&Response::has_posterior_snapshot);
  v1::StreamTelemetryRequest manual;
  manual.set_sequence(2);
  manual.mutable_mode_change()->set_mode(v1::MODE_MANUAL);
  client.Send(manual);
  ASSERT_TRUE(Applied(2));
  for (uint64_t sequence = 3; sequence <= 5; ++sequence) {
    client.Send(Frames(sequence, 30, 50));
    ASSERT_TRUE(Applied(sequence));
    const uint64_t decision_count = server_->counters().decision_count;
    Tick();
    // A tick that has not run yet would include the next frames in its window.
    ASSERT_TRUE(Eventually([&] { return server_->counters().decision_count > decision_count; }));
  }
  const v1::PosteriorSnapshot snapshot =
      client.Await(&Response::has_posterior_snapshot).posterior_snapshot();
  EXPECT_EQ(snapshot.verdict(), v1::VERDICT_DEGRADED);
  EXPECT_EQ(snapshot.arms_size(), 1);
}

TEST_F(ResponseTest, AnAcknowledgementComesOnlyWhenTheStoreHasCommitted) {
  TelemetryClient client(channel_);
  client.Open(OneArmHello());
  client.Send(Frames(1, 30));
  ASSERT_TRUE(Applied(1));
  store_.Hold();
  Tick();
  // A tick that has not run yet would include the next frames in its window.
  ASSERT_TRUE(Eventually([&] { return server_->counters().decision_count == 1; }));
  ASSERT_TRUE(Eventually([&] { return store_.held_count() == 1; }));
  client.Send(Frames(2, 30));
  ASSERT_TRUE(Applied(2));
  Tick();
  // The posteriors of the first window are sent now, because they waited for its commit. If the
  // welcome message was still being written, they were sent right after it.
  for (double observations = 0; observations < 4;) {
    const std::optional<Response> next = client.Read();
    ASSERT_TRUE(next);
    EXPECT_FALSE(next->has_acknowledgement());
    const v1::BetaPosterior& arm = next->posterior_snapshot().arms(0);
    observations = arm.alpha() + arm.beta();
  }
  EXPECT_TRUE(Stored().arms.empty());
  store_.Release();
  EXPECT_EQ(client.AwaitAcknowledgement(2), 2u);
  EXPECT_EQ(Stored().arms[0].live.window_count, 2u);
}

}  // namespace
}  // namespace sweepstake::rpc
