// An operator pins a game to an arm, with the real daemon and the real client.
#include <gmock/gmock.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include <atomic>
#include <future>

#include "engine_client/decider/audit/rederive.h"
#include "sweepstake/v1/sessions.grpc.pb.h"
#include "tests/end_to_end/scripted_game.h"
#include "tests/end_to_end/store_reader.h"
#include "tests/support/daemon_process.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::test_support {
namespace {

using ::testing::HasSubstr;

constexpr uint32_t kPinned = 5;  // one of the slowest arms in kScriptedCosts

class OperatorOrderTest : public ::testing::Test {
 protected:
  static SessionOptions Options(bool allow_operator_orders) {
    SessionOptions options = FastOptions();
    options.allow_operator_orders = allow_operator_orders;
    return options;
  }
  // Sends an order while the game runs, and returns the call's status.
  grpc::Status Order(const DaemonProcess& daemon, ScriptedGame& game, v1::Mode mode,
                     const std::string& arm = "") {
    v1::OrderSessionRequest request;
    request.set_session_id(game.stats().session_id);
    request.set_mode(mode);
    request.set_arm(arm);
    const auto channel = grpc::CreateChannel(daemon.address(), grpc::InsecureChannelCredentials());
    const auto stub = v1::SessionsService::NewStub(channel);
    std::future<grpc::Status> status = std::async(std::launch::async, [&] {
      grpc::ClientContext context;
      return stub->OrderSession(&context, request, &response_);
    });
    game.RunUntil([&](const SessionStats&) {
      return status.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
    });
    return status.get();
  }
  static bool Settles(ScriptedGame& game) {
    return game.RunUntil([&](const SessionStats& stats) {
      return game.adaptive().active_arm() == kScriptedBest && LearntEvidence(stats) >= 50;
    });
  }
  // Runs until the daemon has acknowledged some more decisions.
  static bool PlayOn(ScriptedGame& game) {
    const uint64_t acknowledged = game.stats().acknowledged_sequence;
    return game.RunUntil([&](const SessionStats& stats) {
      return stats.acknowledged_sequence >= acknowledged + 40;
    });
  }

  const TemporaryDirectory data_;
  v1::OrderSessionResponse response_;
};

TEST_F(OperatorOrderTest, APinnedGameKeepsItsArmAcrossARestartUntilItsRelease) {
  auto daemon = std::make_unique<DaemonProcess>(data_.path());
  const std::string address = daemon->address();
  ScriptedGame game(address, Options(/*allow_operator_orders=*/true));
  ASSERT_TRUE(Settles(game)) << game.stats().last_error;
  const std::string arm = game.adaptive().arms()[kPinned];
  const grpc::Status pinned = Order(*daemon, game, v1::MODE_MANUAL, arm);
  ASSERT_TRUE(pinned.ok()) << pinned.error_message();
  EXPECT_EQ(response_.active_arm(), arm);
  EXPECT_EQ(game.adaptive().active_arm(), kPinned);
  ASSERT_TRUE(PlayOn(game));
  const double evidence = LearntEvidence(game.stats());
  const uint64_t command_count = game.stats().command_count;
  ASSERT_TRUE(PlayOn(game));
  daemon->Kill();
  game.RunFrames(100);
  daemon = std::make_unique<DaemonProcess>(data_.path(), address);
  ASSERT_TRUE(game.RunUntil([](const SessionStats& stats) { return stats.connection_count == 2; }));
  ASSERT_TRUE(PlayOn(game));
  EXPECT_EQ(game.adaptive().active_arm(), kPinned);
  EXPECT_EQ(game.stats().command_count, command_count);
  // A window would add one observation. Small differences come from different rounding in the store
  // and in a session.
  EXPECT_LT(LearntEvidence(game.stats()), evidence + 0.5) << "the daemon must learn nothing";
  const grpc::Status released = Order(*daemon, game, v1::MODE_AI);
  ASSERT_TRUE(released.ok()) << released.error_message();
  EXPECT_TRUE(Settles(game));
  game.Stop();
  EXPECT_EQ(daemon->Terminate(), 0);
  const std::vector<decision::AuditRow> log = ReadAuditLog(data_.path());
  EXPECT_TRUE(std::any_of(log.begin(), log.end(), [](const decision::AuditRow& row) {
    return row.kind == decision::AuditKind::kOrder;
  }));
  const decision::AuditReport report = decision::Rederive(log);
  EXPECT_FALSE(report.difference) << report.difference->Text();
  EXPECT_EQ(game.wait_count(), 0U) << "the frame thread must never wait";
}

TEST_F(OperatorOrderTest, ABailOutEndsThePinAndIsAnswered) {
  DaemonProcess daemon(data_.path());
  ScriptedGame game(daemon.address(), Options(/*allow_operator_orders=*/true));
  ASSERT_TRUE(Settles(game)) << game.stats().last_error;
  ASSERT_TRUE(Order(daemon, game, v1::MODE_MANUAL, game.adaptive().arms()[kPinned]).ok());
  game.BailOut();
  EXPECT_EQ(game.adaptive().mode(), Mode::kAi);
  EXPECT_TRUE(
      game.RunUntil([&](const SessionStats&) { return game.adaptive().active_arm() != kPinned; }));
}

TEST_F(OperatorOrderTest, AShippedGameRefusesOrders) {
  DaemonProcess daemon(data_.path());
  ScriptedGame game(daemon.address(), Options(/*allow_operator_orders=*/false));
  ASSERT_TRUE(Settles(game)) << game.stats().last_error;
  const grpc::Status status = Order(daemon, game, v1::MODE_MANUAL, game.adaptive().arms()[kPinned]);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_THAT(status.error_message(), HasSubstr("allow_operator_orders"));
  EXPECT_EQ(game.adaptive().mode(), Mode::kAi);
}

}  // namespace
}  // namespace sweepstake::test_support
