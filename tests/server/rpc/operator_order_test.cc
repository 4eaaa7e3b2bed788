// An operator's order is sent to the game, and the game's answer is returned.
#include <functional>
#include <utility>
#include <vector>

#include "server/rpc/common/proto_conversion.h"
#include "server/sessions/game_session.h"
#include "server/sessions/session_start.h"
#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::rpc {
namespace {

// Records the messages to the client.
class RecordingLink final : public sessions::ClientStream {
 public:
  void SendSwitch(const SwitchCommand& command) override { switches.push_back(command); }
  void SendAcknowledgement(uint64_t /*sequence*/) override {}
  void PutSnapshot(const decision::DecisionRecord& /*record*/) override {}
  void Flush() override {}
  void SendReconnect(uint32_t /*delay_ms*/) override {}
  void SendBoxRequest(uint32_t /*interval_ms*/, uint32_t /*max_bytes*/,
                      uint32_t /*until_ms*/) override {}
  void SendOrder(uint64_t order_id, const decision::OrderReport& order) override {
    order_ids.push_back(order_id);
    orders.push_back(order);
  }
  bool SpendBailOut() override { return true; }
  void Close(const absl::Status& /*status*/) override {}
  void Abort(const absl::Status& /*status*/) override {}

  std::vector<SwitchCommand> switches;
  std::vector<uint64_t> order_ids;
  std::vector<decision::OrderReport> orders;
};

class OperatorOrderTest : public ::testing::Test {
 protected:
  void SetUp() override {
    OnLoop([&] {
      session_ = *sessions::MakeSession(context_, FromProto(HelloMessage()), {});
      Begin(/*takes_orders=*/true);
    });
  }
  void TearDown() override {
    OnLoop([&] {
      session_->Detach(link_);
      session_.reset();
    });
    thread_.Close();
    OnLoop([] {});
  }
  // Connects the game. Runs on the loop.
  void Begin(bool takes_orders) {
    v1::Hello hello = HelloMessage();
    if (takes_orders) hello.add_capabilities(v1::CAPABILITY_OPERATOR_ORDERS);
    session_->Attach(link_);
    session_->Start(FromProto(hello));
  }
  // Runs the task on the loop and waits for it.
  void OnLoop(const std::function<void()>& task) {
    std::promise<void> done;
    loop_.Post([&] {
      task();
      done.set_value();
    });
    done.get_future().wait();
  }
  void Order(Mode mode, std::optional<uint32_t> arm = std::nullopt) {
    OnLoop([&] {
      session_->Order(
          {.operator_name = "alice", .mode = mode, .arm = arm, .now_ns = clock_.NowNs()},
          [this](const absl::Status& status) { answers_.push_back(status.code()); });
    });
  }
  void ChangeMode(v1::Mode mode, uint32_t arm, uint64_t order_id) {
    v1::StreamTelemetryRequest request;
    request.set_sequence(++sequence_);
    request.mutable_mode_change()->set_mode(mode);
    request.mutable_mode_change()->set_active_arm(arm);
    request.mutable_mode_change()->set_order_id(order_id);
    Apply(request);
  }
  void Apply(const v1::StreamTelemetryRequest& request) {
    sessions::Telemetry telemetry;
    FromProto(request, telemetry);
    OnLoop([&] { session_->Apply(telemetry); });
  }
  void Play(uint32_t arm, uint32_t epoch) {
    Apply(Frames(++sequence_, 30, 10, arm, epoch));
    clock_.Advance(options_.decision.decision_interval_ns);
    OnLoop([] {});
  }

  RpcOptions options_;
  sessions::ManualClock clock_;
  Counters counters_;
  storage::StoreThread thread_{*storage::OpenMemoryPriorStore(), {}};
  sessions::DecisionLoop loop_{clock_};
  EventEncoder encoder_;
  events::EventBus events_{thread_, loop_, table_, encoder_};
  sessions::SessionContext context_{options_, loop_, thread_, counters_, events_};
  sessions::SessionTable table_{context_};
  RecordingLink link_;
  std::shared_ptr<sessions::GameSession> session_;
  uint64_t sequence_ = 0;
  std::vector<absl::StatusCode> answers_;
};

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST_F(OperatorOrderTest, IsAnsweredWhenExecutedAndPinsTheArmUntilReleased) {
  Order(Mode::kManual, 2);
  ASSERT_EQ(link_.orders.size(), 1u);
  EXPECT_EQ(link_.orders[0].arm, 2u);
  EXPECT_THAT(answers_, IsEmpty());
  ChangeMode(v1::MODE_MANUAL, 2, link_.order_ids[0]);
  EXPECT_THAT(answers_, ElementsAre(absl::StatusCode::kOk));
  EXPECT_EQ(session_->decisions().active_arm(), 2u);
  const auto before = std::vector(session_->decisions().posteriors().begin(),
                                  session_->decisions().posteriors().end());
  for (int window = 0; window < 40; ++window) Play(2, 1);
  EXPECT_THAT(link_.switches, IsEmpty());
  EXPECT_THAT(session_->decisions().posteriors(), ::testing::ElementsAreArray(before))
      << "nothing is learnt";
  Order(Mode::kAi);
  ChangeMode(v1::MODE_AI, 2, link_.order_ids[1]);
  EXPECT_THAT(answers_, ElementsAre(absl::StatusCode::kOk, absl::StatusCode::kOk));
  for (int window = 0; window < 40; ++window) Play(2, 1);
  EXPECT_FALSE(link_.switches.empty()) << "decisions continue";
}

TEST_F(OperatorOrderTest, IsAFailedPreconditionIfTheGameRefuses) {
  Order(Mode::kManual, 1);
  v1::StreamTelemetryRequest request;
  request.set_sequence(1);
  request.mutable_order_refusal()->set_order_id(link_.order_ids[0]);
  request.mutable_order_refusal()->set_reason(v1::ORDER_REFUSAL_REASON_NOT_ALLOWED);
  Apply(request);
  EXPECT_THAT(answers_, ElementsAre(absl::StatusCode::kFailedPrecondition));
  EXPECT_EQ(session_->decisions().mode(), Mode::kAi);
}

TEST_F(OperatorOrderTest, IsNotSentToAGameThatAcceptsNoOrders) {
  OnLoop([this] { Begin(/*takes_orders=*/false); });
  Order(Mode::kManual, 2);
  EXPECT_THAT(link_.orders, IsEmpty());
  EXPECT_THAT(answers_, ElementsAre(absl::StatusCode::kFailedPrecondition));
}

TEST_F(OperatorOrderTest, IsNotConfirmedByAnotherChangeOfMode) {
  Order(Mode::kManual, 1);
  ChangeMode(v1::MODE_MANUAL, 1, 0);
  ChangeMode(v1::MODE_MANUAL, 1, link_.order_ids[0] - 1);
  EXPECT_THAT(answers_, IsEmpty());
}

TEST_F(OperatorOrderTest, IsReplacedByALaterOneAndAnsweredOnce) {
  Order(Mode::kManual, 1);
  Order(Mode::kManual, 2);
  EXPECT_THAT(answers_, ElementsAre(absl::StatusCode::kAborted));
  EXPECT_GT(link_.order_ids[1], link_.order_ids[0]);
  ChangeMode(v1::MODE_MANUAL, 1, link_.order_ids[0]);
  EXPECT_EQ(answers_.size(), 1u);
  ChangeMode(v1::MODE_MANUAL, 2, link_.order_ids[1]);
  EXPECT_THAT(answers_, ElementsAre(absl::StatusCode::kAborted, absl::StatusCode::kOk));
}

TEST_F(OperatorOrderTest, EndsAfterFiveSecondsWithoutAnAnswer) {
  Order(Mode::kManual, 1);
  clock_.Advance(5 * kSecondNs - 1);
  OnLoop([] {});
  EXPECT_THAT(answers_, IsEmpty());
  clock_.Advance(1);
  ASSERT_TRUE(Eventually([&] {
    bool answered = false;
    OnLoop([&] { answered = !answers_.empty(); });
    return answered;
  }));
  EXPECT_THAT(answers_, ElementsAre(absl::StatusCode::kDeadlineExceeded));
}

TEST_F(OperatorOrderTest, EndsWhenTheGameIsLostAndIsNotSentToALostGame) {
  Order(Mode::kManual, 1);
  OnLoop([&] { session_->Detach(link_); });
  EXPECT_THAT(answers_, ElementsAre(absl::StatusCode::kUnavailable));
  Order(Mode::kManual, 1);
  EXPECT_EQ(answers_.size(), 2u);
  EXPECT_EQ(link_.orders.size(), 1u);
  RecordingLink next;
  OnLoop([&] { session_->Attach(next); });
  Order(Mode::kManual, 1);
  OnLoop([&] { session_->Attach(link_); });
  EXPECT_EQ(answers_.size(), 3u) << "another connection has resumed the session";
}

}  // namespace
}  // namespace sweepstake::rpc
