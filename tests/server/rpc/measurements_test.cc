// Tests the measurements of frame costs that watchers receive.
#include <cmath>
#include <vector>

#include "server/sessions/common/log_histogram.h"
#include "sweepstake/v1/posteriors.grpc.pb.h"
#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::rpc {
namespace {

uint64_t CountOf(const v1::LogHistogram& histogram) {
  uint64_t sum = 0;
  for (const uint32_t count : histogram.counts()) sum += count;
  return sum;
}

class MeasurementsTest : public RpcTest {
 protected:
  void SetUp() override {
    RpcTest::SetUp();
    stub_ = v1::PosteriorsService::NewStub(channel_);
  }
  void TearDown() override {
    context_.TryCancel();
    reader_.reset();
    stub_.reset();
    RpcTest::TearDown();
  }
  void Watch() {
    reader_ = stub_->WatchPosteriors(&context_, {});
    ASSERT_TRUE(Eventually([&] { return server_->counters().open_watcher_count == 1; }));
  }
  // Sends the message, and makes the decision that follows it.
  void Decide(TelemetryClient& client, const v1::StreamTelemetryRequest& message) {
    client.Send(message);
    EXPECT_TRUE(Applied(message.sequence()));
    Tick();
    EXPECT_TRUE(
        Eventually([&] { return server_->counters().decision_count == message.sequence(); }));
  }
  // Advances to the tick at which decisions are published, and returns them once there are `count`.
  std::vector<v1::DecisionEvent> Told(size_t count) {
    // This call passes the loop, so the loop has then published its decisions.
    grpc::ClientContext context;
    v1::ListPosteriorsResponse response;
    EXPECT_TRUE(stub_->ListPosteriors(&context, {}, &response).ok());
    clock_.Advance(events::EventBus::kIntervalNs);
    std::vector<v1::DecisionEvent> told;
    v1::WatchPosteriorsResponse event;
    while (told.size() < count && reader_->Read(&event))
      told.insert(told.end(), event.decisions().begin(), event.decisions().end());
    EXPECT_EQ(told.size(), count);
    told.resize(count);
    return told;
  }
  v1::DecisionEvent DecideAndTell(TelemetryClient& client,
                                  const v1::StreamTelemetryRequest& message) {
    Decide(client, message);
    return Told(1)[0];
  }

  grpc::ClientContext context_;
  std::unique_ptr<v1::PosteriorsService::Stub> stub_;
  std::unique_ptr<grpc::ClientReader<v1::WatchPosteriorsResponse>> reader_;
};

TEST_F(MeasurementsTest, AWatcherReceivesTheFrameCostsOfEachWindow) {
  Watch();
  TelemetryClient client(channel_);
  client.Open(OneArmHello());
  EXPECT_FALSE(DecideAndTell(client, Frames(1, 30)).has_measurements())
      << "there were no watchers before";
  v1::StreamTelemetryRequest frames = Frames(2, 30);
  frames.mutable_frame_batch()->set_flags(0, v1::FRAME_FLAG_PAUSED);
  frames.mutable_frame_batch()->set_flags(1, v1::FRAME_FLAG_LOADING);
  frames.mutable_frame_batch()->set_flags(3, v1::FRAME_FLAG_SUSPENDED);
  frames.mutable_frame_batch()->set_flags(4, v1::FRAME_FLAG_PAIRS_EXCEEDED);
  frames.mutable_frame_batch()->set_frame_time_ns(2, 40'000'000);
  const v1::FrameMeasurements told = DecideAndTell(client, frames).measurements();
  const uint32_t usual = sessions::LogHistogram::BucketOf(10'000'000);
  ASSERT_EQ(told.frame_time_ns().counts_size(), 2);
  EXPECT_EQ(told.frame_time_ns().bucket_steps(0), usual);
  EXPECT_EQ(told.frame_time_ns().bucket_steps(1), 16U) << "four times as much: two octaves";
  EXPECT_EQ(told.frame_time_ns().counts(0), 25U);
  EXPECT_EQ(told.frame_time_ns().counts(1), 1U);
  EXPECT_EQ(CountOf(told.detection_time_ns()), 26U);
  EXPECT_EQ(told.native_bytes().bucket_steps(0), sessions::LogHistogram::BucketOf(1 << 20));
  const v1::DecisionEvent next = DecideAndTell(client, Frames(3, 5));
  EXPECT_EQ(CountOf(next.measurements().frame_time_ns()), 5U) << "only the frames of this window";
}

TEST_F(MeasurementsTest, ArePublishedAtMostFourTimesASecondWithoutLosingFrames) {
  options_.decision.decision_interval_ns = 100'000'000;
  RestartServer();
  stub_ = v1::PosteriorsService::NewStub(channel_);
  Watch();
  TelemetryClient client(channel_);
  client.Open(OneArmHello());
  std::vector<uint64_t> counts;
  for (uint64_t message = 1; message <= 8; ++message) Decide(client, Frames(message, 10));
  for (const v1::DecisionEvent& decision : Told(8))
    counts.push_back(CountOf(decision.measurements().frame_time_ns()));
  EXPECT_EQ(counts, (std::vector<uint64_t>{0, 10, 0, 0, 30, 0, 0, 30}));
}

TEST_F(MeasurementsTest, AreAtMostAKilobyteForAnyInput) {
  Watch();
  TelemetryClient client(channel_);
  client.Open(OneArmHello());
  DecideAndTell(client, Frames(1, 1));
  v1::StreamTelemetryRequest frames = Frames(2, kMaxBatchFrames, 3'600'000);
  v1::FrameBatch& batch = *frames.mutable_frame_batch();
  for (int i = 0; i < batch.frame_time_ns_size(); ++i) {
    const auto size = static_cast<uint64_t>(std::exp2(10 + i / 8.0));
    batch.set_frame_time_ns(i, std::clamp<uint64_t>(size, 1'000, sessions::kMaxFrameNs));
    batch.set_detection_time_ns(i, std::min(size, batch.frame_time_ns(i)));
    batch.set_native_bytes(i, std::min<uint64_t>(size, 1ull << 45));
  }
  const v1::FrameMeasurements told = DecideAndTell(client, frames).measurements();
  EXPECT_EQ(told.frame_time_ns().counts_size(), 64);
  EXPECT_EQ(CountOf(told.frame_time_ns()), kMaxBatchFrames);
  EXPECT_LE(told.ByteSizeLong(), 1'024U);
}

}  // namespace
}  // namespace sweepstake::rpc
