// Tests when a session sends boxes to its daemon, and their order among its other messages.
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "engine_client/telemetry/protocol/session_link.h"
#include "sweepstake/v1/telemetry.pb.h"

namespace sweepstake {
namespace {

class BoxLinkTest : public ::testing::Test {
 protected:
  // Connects to a daemon that supports box views and requests boxes every 250 ms.
  v1::Hello Connect(bool allow_box_view) {
    SessionOptions options;
    options.batch_frames = 1;
    options.allow_box_view = allow_box_view;
    link_.emplace(options, "the daemon", 7, queue_, *adaptive_);
    link_->Connected(kNowNs);
    const v1::Hello hello = Take().hello();
    v1::StreamTelemetryResponse response;
    response.mutable_welcome()->set_session_id("a");
    response.mutable_welcome()->add_capabilities(v1::CAPABILITY_BOX_VIEW);
    response.mutable_box_request()->set_interval_ms(250);
    response.mutable_box_request()->set_max_bytes(1000);
    response.mutable_box_request()->set_until_ms(5000);
    EXPECT_TRUE(link_->OnMessage(response.SerializeAsString(), kNowNs).ok());
    EXPECT_EQ(link_->Advance(kNowNs), LinkAction::kNone) << "there was no frame";
    return hello;
  }
  void Frame() {
    adaptive_->BeginFrame();
    adaptive_->FindPairs(std::vector<Aabb>(3));
    adaptive_->EndFrame({.frame_time_ns = 1000});
  }
  v1::StreamTelemetryRequest Take() {
    v1::StreamTelemetryRequest request;
    EXPECT_EQ(link_->Advance(kNowNs), LinkAction::kSend);
    EXPECT_TRUE(request.ParseFromString(link_->Take(kNowNs)));
    return request;
  }

  static constexpr uint64_t kNowNs = 1'000'000'000;
  SampleQueue queue_{64};
  std::unique_ptr<AdaptiveBroadPhase> adaptive_ =
      std::move(*AdaptiveBroadPhase::Create({.arms = {"BruteForce", "Grid"}}, &queue_));
  std::optional<SessionLink> link_;
};

TEST_F(BoxLinkTest, SendsNoViewUnlessTheGameAllowsIt) {
  const v1::Hello hello = Connect(/*allow_box_view=*/false);
  ASSERT_EQ(hello.capabilities_size(), 1);
  EXPECT_EQ(hello.capabilities(0), v1::CAPABILITY_STOPS_TRIALS);
  Frame();
  EXPECT_EQ(Take().sequence(), 1U);
  EXPECT_EQ(link_->Advance(kNowNs), LinkAction::kNone);
}

TEST_F(BoxLinkTest, SendsAViewAfterTheEvidenceWithoutASequenceNumber) {
  EXPECT_EQ(Connect(/*allow_box_view=*/true).capabilities(0), v1::CAPABILITY_BOX_VIEW);
  Frame();
  EXPECT_EQ(Take().sequence(), 1U);
  const v1::StreamTelemetryRequest view = Take();
  EXPECT_EQ(view.box_view().object_count(), 3U);
  EXPECT_EQ(view.sequence(), 0U);
  EXPECT_EQ(link_->Advance(kNowNs), LinkAction::kNone);
  EXPECT_EQ(link_->stats().sent_sequence, 1U);
}

TEST_F(BoxLinkTest, SendsNoViewAfterAGoodbye) {
  Connect(/*allow_box_view=*/true);
  Frame();
  Take();
  EXPECT_EQ(link_->Advance(kNowNs), LinkAction::kSend);
  link_->Goodbye(2 * kNowNs);
  EXPECT_TRUE(Take().has_goodbye());
}

}  // namespace
}  // namespace sweepstake
