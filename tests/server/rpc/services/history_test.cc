// Tests that the history has what sessions ran, in the series of their scene, build and session.
#include "server/history/history.h"

#include "sweepstake/v1/history.grpc.pb.h"
#include "tests/server/rpc/rpc_test_fixture.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::rpc {
namespace {

class HistoryTest : public RpcTest {
 protected:
  void SetUp() override {
    auto history =
        history::History::Open(directory_.path() / "history.db", {},
                               [](const std::string& problem) { ADD_FAILURE() << problem; });
    ASSERT_TRUE(history.ok()) << history.status();
    history_ = *std::move(history);
    options_.history = history_.get();
    RpcTest::SetUp();
  }
  // Opens a session of the build, and sends 30 frames of 10 ms. REQUIRES: it is the first session
  // of this server.
  void Play(const std::string& build, bool ends) {
    TelemetryClient client(channel_);
    v1::Hello hello = HelloMessage();
    hello.set_build(build);
    LearnOneWindow(client, hello);
    if (!ends) return;
    client.Send(Goodbye());
    EXPECT_TRUE(client.Finish().ok());
  }
  // Returns the series of the whole history.
  std::vector<v1::HistorySeries> Get(v1::HistoryKind kind, uint32_t max_points = 1) {
    v1::GetHistoryRequest request;
    request.set_kind(kind);
    request.set_max_points(max_points);
    grpc::ClientContext context;
    v1::GetHistoryResponse response;
    const grpc::Status status =
        v1::HistoryService::NewStub(channel_)->GetHistory(&context, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    return {response.series().begin(), response.series().end()};
  }
  grpc::Status Refusal(const v1::GetHistoryRequest& request) {
    grpc::ClientContext context;
    v1::GetHistoryResponse response;
    return v1::HistoryService::NewStub(channel_)->GetHistory(&context, request, &response);
  }

  const test_support::TemporaryDirectory directory_;
  std::unique_ptr<history::History> history_;
};

TEST_F(HistoryTest, SessionsAreAddedToTheirSceneAndBuild) {
  for (const char* build : {"11", "12", "12"}) {
    Play(build, /*ends=*/true);
    RestartServer();
  }
  const auto scenes = Get(v1::HISTORY_KIND_SCENE);
  ASSERT_EQ(scenes.size(), 1U);
  EXPECT_EQ(scenes[0].scene(), "harbour");
  EXPECT_EQ(scenes[0].build(), "");
  ASSERT_EQ(scenes[0].points_size(), 1);
  const v1::HistoryPoint& point = scenes[0].points(0);
  ASSERT_EQ(point.frame_time_ns().counts_size(), 1);
  EXPECT_EQ(point.frame_time_ns().counts(0), 90U);
  EXPECT_EQ(point.detection_time_ns().bucket_steps(0), sessions::LogHistogram::BucketOf(5'000'000));
  ASSERT_EQ(point.arms_size(), 3);
  EXPECT_EQ(point.arms(0).arm(), "Grid");
  EXPECT_EQ(point.arms(0).active_frame_count(), 90U);
  EXPECT_EQ(point.arms(2).active_frame_count(), 0U);
  const auto builds = Get(v1::HISTORY_KIND_BUILD);
  ASSERT_EQ(builds.size(), 2U);
  EXPECT_EQ(builds[0].build(), "11");
  EXPECT_EQ(builds[0].points(0).frame_time_ns().counts(0), 30U);
  EXPECT_EQ(builds[1].points(0).frame_time_ns().counts(0), 60U);
  EXPECT_EQ(builds[1].points(0).session_count(), 2U);
  const auto sessions = Get(v1::HISTORY_KIND_SESSION);
  ASSERT_EQ(sessions.size(), 3U);
  EXPECT_EQ(sessions[0].points(0).frame_time_ns().counts(0), 30U);
  EXPECT_NE(sessions[0].session_id(), sessions[1].session_id());
}

TEST_F(HistoryTest, MeasuredFramesHaveTheirDetectionTime) {
  Play("", /*ends=*/true);
  RestartServer();
  const v1::HistoryPoint point = Get(v1::HISTORY_KIND_SCENE).at(0).points(0);
  EXPECT_EQ(point.frame_count(), 30U);
  EXPECT_DOUBLE_EQ(point.ran_us(), 30 * 5'000.0);
  EXPECT_DOUBLE_EQ(point.initial_us(), 30 * 5'000.0);
  EXPECT_EQ(point.arms(0).frame_count(), 30U);
}

TEST_F(HistoryTest, AStoppedDaemonKeepsWhatSessionsRan) {
  Play("", /*ends=*/false);
  RestartServer();
  EXPECT_EQ(Get(v1::HISTORY_KIND_SESSION).size(), 1U);
}

TEST_F(HistoryTest, AConnectedSessionIsInTheHistoryWithItsActivity) {
  TelemetryClient client(channel_);
  client.Open(HelloMessage());
  client.Send(Frames(1, 30));
  ASSERT_TRUE(Applied(1));
  Tick();
  client.AwaitAcknowledgement(1);
  client.Cancel();  // a lost session reports
  ASSERT_TRUE(Eventually([&] { return server_->counters().open_stream_count == 0; }));
  TelemetryClient other(channel_);
  other.Open(HelloMessage());
  clock_.Advance(history::HistoryRecorder::kDelayNs);
  ASSERT_TRUE(Eventually([&] { return !Get(v1::HISTORY_KIND_SCENE).empty(); }));
  const v1::HistoryPoint point = Get(v1::HISTORY_KIND_SCENE, 2).at(0).points(0);
  EXPECT_EQ(point.activity().active_arm(), "Grid");
  EXPECT_EQ(point.activity().arms_size(), 3);
}

TEST_F(HistoryTest, InvalidRequestsAreRefused) {
  v1::GetHistoryRequest request;
  EXPECT_EQ(Refusal(request).error_code(), grpc::INVALID_ARGUMENT) << "without a kind";
  request.set_kind(v1::HISTORY_KIND_SCENE);
  EXPECT_TRUE(Refusal(request).ok());
  request.set_max_points(10'001);
  EXPECT_EQ(Refusal(request).error_code(), grpc::INVALID_ARGUMENT);
  request.set_max_points(0);
  request.set_from_unix_ms(10);
  request.set_until_unix_ms(10);
  EXPECT_EQ(Refusal(request).error_code(), grpc::INVALID_ARGUMENT);
  request.set_until_unix_ms(11);
  EXPECT_TRUE(Refusal(request).ok());
  request.set_page_token("x");
  EXPECT_EQ(Refusal(request).error_code(), grpc::INVALID_ARGUMENT);
}

}  // namespace
}  // namespace sweepstake::rpc
