// Tests how a game reacts to an operator's orders, over real gRPC on the loopback.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "sweepstake/session.h"
#include "tests/support/fake_daemon.h"

namespace sweepstake {
namespace {

using test_support::FakeDaemon;
using Request = v1::StreamTelemetryRequest;

class OperatorOrderTest : public ::testing::Test {
 protected:
  void Start(bool allow_operator_orders) {
    daemon_.SetScript([this](FakeDaemon::Script& script) {
      if (daemon_passes_orders_) script.welcome.add_capabilities(v1::CAPABILITY_OPERATOR_ORDERS);
    });
    daemon_.Start();
    SessionOptions options;
    options.batch_interval_ms = 1;
    options.allow_operator_orders = allow_operator_orders;
    session_ = std::move(*MakeDaemonSession(daemon_.address(), options));
    adaptive_ = std::move(
        *AdaptiveBroadPhase::Create({.arms = {"BruteForce", "Grid", "SAP"}}, &session_->sink()));
    ASSERT_TRUE(session_->Start(*adaptive_).ok());
    RunUntil([&] { return session_->stats().state == ConnectionState::kOnline; });
  }

  template <typename Condition>
  void RunUntil(Condition condition) {
    while (!condition()) {
      adaptive_->BeginFrame();
      adaptive_->FindPairs(boxes_);
      adaptive_->EndFrame({.frame_time_ns = 10'000'000});
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }
  void Order(uint64_t id, v1::Mode mode, std::optional<uint32_t> arm = std::nullopt) {
    v1::StreamTelemetryResponse response;
    response.mutable_operator_order()->set_order_id(id);
    response.mutable_operator_order()->set_mode(mode);
    if (arm) response.mutable_operator_order()->set_arm(*arm);
    ASSERT_TRUE(daemon_.Send(response));
  }
  // Returns the message that answers the order.
  Request Answer(uint64_t order_id) {
    const auto answers = [order_id](const Request& request) {
      return request.mode_change().order_id() == order_id ||
             request.order_refusal().order_id() == order_id;
    };
    for (;;) {
      const std::vector<Request> evidence = daemon_.Evidence();
      const auto found = std::find_if(evidence.begin(), evidence.end(), answers);
      if (found != evidence.end()) return *found;
      RunUntil([&] { return daemon_.Evidence().size() > evidence.size(); });
    }
  }

  FakeDaemon daemon_;
  bool daemon_passes_orders_ = true;
  std::unique_ptr<Session> session_;
  std::unique_ptr<AdaptiveBroadPhase> adaptive_;
  const std::vector<Aabb> boxes_ = std::vector<Aabb>(4);
};

TEST_F(OperatorOrderTest, IsRefusedUnlessTheGameAllowsIt) {
  Start(/*allow_operator_orders=*/false);
  Order(1, v1::MODE_MANUAL, 2);
  EXPECT_EQ(Answer(1).order_refusal().reason(), v1::ORDER_REFUSAL_REASON_NOT_ALLOWED);
  EXPECT_EQ(adaptive_->mode(), Mode::kAi);
  EXPECT_EQ(adaptive_->switch_epoch(), 0U);
}

TEST_F(OperatorOrderTest, IsRefusedWhileTheGameIsFrozen) {
  Start(/*allow_operator_orders=*/true);
  adaptive_->Freeze();
  Order(1, v1::MODE_AI, {});
  EXPECT_EQ(Answer(1).order_refusal().reason(), v1::ORDER_REFUSAL_REASON_NOT_ALLOWED);
}

TEST_F(OperatorOrderTest, IsRefusedIfTheDaemonDoesNotSupportOrders) {
  daemon_passes_orders_ = false;
  Start(/*allow_operator_orders=*/true);
  Order(1, v1::MODE_MANUAL, 2);
  EXPECT_EQ(Answer(1).order_refusal().reason(), v1::ORDER_REFUSAL_REASON_NOT_ALLOWED);
  EXPECT_EQ(adaptive_->mode(), Mode::kAi);
}

TEST_F(OperatorOrderTest, TheHelloStatesWhetherTheGameAcceptsOrders) {
  for (const bool takes : {false, true}) {
    Start(takes);
    session_->Stop(0);
    daemon_.Kill();
  }
  ASSERT_EQ(daemon_.hellos.size(), 2U);
  ASSERT_EQ(daemon_.hellos[0].capabilities_size(), 1);
  EXPECT_EQ(daemon_.hellos[0].capabilities(0), v1::CAPABILITY_STOPS_TRIALS);
  ASSERT_EQ(daemon_.hellos[1].capabilities_size(), 2);
  EXPECT_EQ(daemon_.hellos[1].capabilities(0), v1::CAPABILITY_OPERATOR_ORDERS);
  EXPECT_EQ(daemon_.hellos[1].capabilities(1), v1::CAPABILITY_STOPS_TRIALS);
}

TEST_F(OperatorOrderTest, IsExecutedAndAnsweredWithTheActiveArm) {
  Start(/*allow_operator_orders=*/true);
  Order(1, v1::MODE_MANUAL, 2);
  const Request pinned = Answer(1);
  EXPECT_EQ(pinned.mode_change().mode(), v1::MODE_MANUAL);
  EXPECT_EQ(pinned.mode_change().active_arm(), 2U);
  EXPECT_EQ(adaptive_->active_arm(), 2U);
  Order(2, v1::MODE_AI);
  EXPECT_EQ(Answer(2).mode_change().mode(), v1::MODE_AI);
  EXPECT_EQ(adaptive_->mode(), Mode::kAi);
}

TEST_F(OperatorOrderTest, WithAnUnknownModeOrArmIsRefused) {
  Start(/*allow_operator_orders=*/true);
  Order(1, v1::MODE_MANUAL, 3);
  EXPECT_EQ(Answer(1).order_refusal().reason(), v1::ORDER_REFUSAL_REASON_UNKNOWN);
  Order(2, static_cast<v1::Mode>(7));
  EXPECT_EQ(Answer(2).order_refusal().reason(), v1::ORDER_REFUSAL_REASON_UNKNOWN);
  EXPECT_EQ(adaptive_->mode(), Mode::kAi);
}

TEST_F(OperatorOrderTest, SurvivesALostConnectionAndIsSentInTheHello) {
  Start(/*allow_operator_orders=*/true);
  Order(1, v1::MODE_MANUAL, 1);
  const uint64_t sequence = Answer(1).sequence();
  RunUntil([&] { return session_->stats().acknowledged_sequence >= sequence; });
  const int port = daemon_.port();
  daemon_.Kill();
  daemon_.Start(port);
  RunUntil([&] { return session_->stats().connection_count == 2; });
  daemon_.WaitUntil([](const FakeDaemon& daemon) { return daemon.hellos.size() >= 2; });
  daemon_.Kill();
  EXPECT_EQ(daemon_.hellos.back().mode(), v1::MODE_MANUAL);
  EXPECT_EQ(daemon_.hellos.back().active_arm(), 1U);
}

}  // namespace
}  // namespace sweepstake
