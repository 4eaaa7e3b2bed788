// If acknowledgements are lost, the game resends messages that are already on disk.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>

#include "tests/end_to_end/store_reader.h"
#include "tests/server/rpc/rpc_test_fixture.h"
#include "tests/support/daemon_process.h"
#include "tests/support/http_exchange.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::test_support {
namespace {

constexpr uint64_t kMessageCount = 20;
constexpr int kFramesPerMessage = 30;

void SendAll(rpc::TelemetryClient& client) {
  for (uint64_t sequence = 1; sequence < kMessageCount; ++sequence)
    client.Send(rpc::Frames(sequence, kFramesPerMessage));
  client.Send(rpc::BailOut(kMessageCount, kMessageCount * 1000));
}

TEST(LostAcknowledgementTest, ResentMessagesThatAreOnDiskCountOnceAlsoAfterAKill) {
  const TemporaryDirectory data;
  auto daemon = std::make_unique<DaemonProcess>(data.path());
  const std::string address = daemon->address();
  // Do not share the first channel's connection, which has failed.
  grpc::ChannelArguments alone;
  alone.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  const auto connect = [&] {
    return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), alone);
  };
  v1::Hello hello = rpc::OneArmHello();
  hello.set_time_scale(200);
  {
    rpc::TelemetryClient client(connect());
    rpc::Resume(hello, client.Open(hello));
    SendAll(client);
    client.AwaitAcknowledgement(kMessageCount);
  }
  daemon->Kill();
  const priors::SourceState before = ReadSource(data.path(), hello.session_id());
  daemon = std::make_unique<DaemonProcess>(data.path(), address,
                                           std::vector<std::string>{"--http", "127.0.0.1:0"});
  rpc::TelemetryClient client(connect());
  const v1::Welcome welcome = client.Open(hello);
  EXPECT_TRUE(welcome.resumed());
  EXPECT_EQ(welcome.acknowledged_sequence(), kMessageCount);
  SendAll(client);
  client.Send(rpc::BailOut(kMessageCount + 1, (kMessageCount + 1) * 1000));
  client.AwaitAcknowledgement(kMessageCount + 1);
  EXPECT_THAT(Get(daemon->http_port(), "/metrics").body,
              ::testing::HasSubstr("sweepstake_replayed_messages_total " +
                                   std::to_string(kMessageCount) + "\n"));
  client.Send(rpc::Goodbye());
  EXPECT_TRUE(client.Finish().ok());
  EXPECT_EQ(daemon->Terminate(), 0);

  const priors::SourceState after = ReadSource(data.path(), hello.session_id());
  EXPECT_EQ(after.progress.message_sequence, kMessageCount + 1);
  EXPECT_EQ(before.progress.frame_count, (kMessageCount - 1) * kFramesPerMessage);
  EXPECT_EQ(after.progress.frame_count, before.progress.frame_count);
  EXPECT_EQ(TotalEvidence(before).bail_out_count, 1u);
  EXPECT_EQ(TotalEvidence(after).bail_out_count, 2u);
  EXPECT_EQ(TotalEvidence(after).window_count, TotalEvidence(before).window_count);
  ExpectConsistent(after);
}

}  // namespace
}  // namespace sweepstake::test_support
