// Measurements of the shadow lane of a real game reach the deciding session over a real stream.
#include <algorithm>
#include <vector>

#include "sweepstake/scene.h"
#include "sweepstake/session.h"
#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::test_support {
namespace {

class ShadowTest : public rpc::RpcTest {
 protected:
  void SetUp() override {
    options_.decision.policy = "adaptive";
    StartServer();
    SessionOptions options;
    options.batch_interval_ms = 1;
    session_ =
        std::move(*MakeDaemonSession("127.0.0.1:" + std::to_string(server_->port()), options));
    auto made = AdaptiveBroadPhase::Create({.initial_arm = "BruteForce",  // the slowest arm
                                            .shadow = {.sweep_interval_min_ns = 1'000'000}},
                                           &session_->sink());
    ASSERT_TRUE(made.ok()) << made.status().message();
    adaptive_ = std::move(*made);
    ASSERT_TRUE(session_->Start(*adaptive_).ok());
  }
  void TearDown() override {
    session_->Stop(0);
    RpcTest::TearDown();
  }

  // Runs frames until `done` returns true.
  template <typename Condition>
  [[nodiscard]] bool PlayUntil(Condition done) {
    return rpc::Eventually([&] {
      scene_->Step();
      adaptive_->BeginFrame();
      adaptive_->FindPairs(scene_->aabbs());
      adaptive_->EndFrame({.frame_time_ns = 10'000'000});
      return done();
    });
  }

  std::unique_ptr<Scene> scene_ = std::move(*MakeScene("suite-b", {.object_count = 3000}));
  std::unique_ptr<Session> session_;  // outlives the frame path, which fills it
  std::unique_ptr<AdaptiveBroadPhase> adaptive_;
};

TEST_F(ShadowTest, MovesTheGameOffTheSlowestArmAlthoughNoOtherWasActive) {
  if (adaptive_->shadow_stats().state == ShadowState::kNoSpareCore) {
    GTEST_SKIP() << "the lane needs a second core";
  }
  ASSERT_TRUE(PlayUntil([&] { return server_->counters().accepted_shadow_count >= 7; }));
  for (const auto& count : server_->counters().rejected_shadow_counts) EXPECT_EQ(count, 0u);
  EXPECT_EQ(server_->counters().invalid_message_count, 0u);
  ASSERT_TRUE(PlayUntil([&] {
    Tick();
    return adaptive_->active_arm() != 0;
  }));
  EXPECT_EQ(adaptive_->last_switch_reason(), SwitchReason::kPolicy);
  EXPECT_EQ(adaptive_->switch_epoch(), 1u);
}

}  // namespace
}  // namespace sweepstake::test_support
