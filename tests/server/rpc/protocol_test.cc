// Tests the intervals of batches, and messages of a newer protocol.
#include "server/sessions/session_start.h"
#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::rpc {
namespace {

class ProtocolTest : public RpcTest {};

TEST_F(ProtocolTest, TheBatchIntervalGrowsWithTheNumberOfStreams) {
  EXPECT_EQ(BatchIntervalMs(2000, 1), 250u);
  EXPECT_EQ(BatchIntervalMs(2000, 2500), 250u);
  EXPECT_EQ(BatchIntervalMs(2000, 5000), 500u);
  EXPECT_EQ(BatchIntervalMs(2000, 10'000), 1000u);
  EXPECT_EQ(BatchIntervalMs(2000, 100'000), 1000u) << "a decision has two batches or more";
  EXPECT_EQ(BatchIntervalMs(2, 10'000), 1u);
}

TEST_F(ProtocolTest, MessagesOfANewerProtocolAreCountedAndTheStreamContinues) {
  TelemetryClient client(channel_);
  client.Open(HelloMessage());
  v1::StreamTelemetryRequest message;
  message.set_sequence(1);
  message.GetReflection()->MutableUnknownFields(&message)->AddLengthDelimited(500, "newer");
  client.Send(message);
  v1::StreamTelemetryRequest mode;
  mode.set_sequence(2);
  mode.mutable_mode_change()->set_mode(static_cast<v1::Mode>(9));
  client.Send(mode);
  v1::StreamTelemetryRequest outcome;
  outcome.set_sequence(3);
  outcome.mutable_switch_outcome()->set_reason(static_cast<v1::SwitchReason>(99));
  client.Send(outcome);
  client.Send(Frames(4, 30));
  ASSERT_TRUE(Applied(1));
  EXPECT_EQ(server_->counters().unknown_message_count, 3u);
  EXPECT_EQ(server_->counters().accepted_frame_count, 30u);
  Tick();
  EXPECT_EQ(client.AwaitAcknowledgement(4), 4u);
}

}  // namespace
}  // namespace sweepstake::rpc
