#include "engine_client/telemetry/protocol/resumable_session.h"

#include <gtest/gtest.h>

namespace sweepstake {
namespace {

constexpr ResumableSession::Position kPosition{
    .active_arm = 2, .switch_epoch = 5, .mode = Mode::kManual};

EvidenceMessage Batch(uint32_t arm = 0, uint32_t epoch = 0) {
  return {.message = "batch", .frame_count = 1, .active_arm = arm, .switch_epoch = epoch};
}

protocol::Welcome WelcomeTo(const std::string& session, bool resumed = false,
                            uint64_t acknowledged = 0) {
  protocol::Welcome welcome;
  welcome.session_id = session;
  welcome.resume_token = "token of " + session;
  welcome.resumed = resumed;
  welcome.acknowledged_sequence = acknowledged;
  return welcome;
}

protocol::Hello BaseHello() {
  protocol::Hello hello;
  hello.project = "game";
  return hello;
}

class SessionStateTest : public ::testing::Test {
 protected:
  std::vector<uint64_t> SendAll() {
    std::vector<uint64_t> sequences;
    while (const auto* entry = state_.Next()) {
      sequences.push_back(entry->sequence);
      state_.MarkSent();
    }
    return sequences;
  }
  void Begin() {
    state_.Connect(kPosition);
    state_.OnWelcome(WelcomeTo("a"));
  }

  using Sequences = std::vector<uint64_t>;
  ResumableSession state_{BaseHello(), 8};
};

TEST_F(SessionStateTest, BeginsANewSessionWithoutAnId) {
  const protocol::Hello hello = state_.Connect(kPosition);
  EXPECT_EQ(hello.project, "game");
  EXPECT_EQ(hello.session_id, "");
  EXPECT_EQ(hello.active_arm, 2U);
  EXPECT_EQ(hello.switch_epoch, 5U);
  EXPECT_EQ(hello.mode, Mode::kManual);
}

TEST_F(SessionStateTest, SendsNothingBeforeTheWelcome) {
  state_.Append(Batch());
  state_.Connect(kPosition);
  EXPECT_EQ(state_.Next(), nullptr);
  state_.OnWelcome(WelcomeTo("a"));
  EXPECT_EQ(SendAll(), Sequences{1});
  EXPECT_EQ(state_.counts().sent_frame_count, 1U);
}

TEST_F(SessionStateTest, ResumesAndResendsOnlyUnacknowledgedMessages) {
  Begin();
  for (int i = 0; i < 4; ++i) state_.Append(Batch());
  SendAll();
  state_.OnAcknowledgement(1);
  state_.Disconnect(false, false);
  const protocol::Hello hello = state_.Connect(kPosition);
  EXPECT_EQ(hello.session_id, "a");
  EXPECT_EQ(hello.resume_token, "token of a");
  state_.Append(Batch());
  state_.OnWelcome(WelcomeTo("a", true, 2));
  EXPECT_EQ(SendAll(), (Sequences{3, 4, 5}));
  EXPECT_EQ(state_.counts().resumed_count, 1U);
  EXPECT_EQ(state_.counts().connection_count, 2U);
  EXPECT_EQ(state_.counts().resent_message_count, 2U);
  EXPECT_EQ(state_.counts().sent_frame_count, 5U);
  EXPECT_EQ(state_.counts().acknowledged_sequence, 2U);
}

TEST_F(SessionStateTest, TheHelloDescribesTheOldestFramesToResend) {
  Begin();
  state_.Append(Batch(1, 3));
  state_.Append(Batch(4, 4));
  SendAll();
  state_.Disconnect(false, false);
  const protocol::Hello hello = state_.Connect(kPosition);
  EXPECT_EQ(hello.active_arm, 1U);
  EXPECT_EQ(hello.switch_epoch, 3U);
}

TEST_F(SessionStateTest, RenumbersMessagesIfTheDaemonForgotTheSession) {
  Begin();
  for (int i = 0; i < 4; ++i) state_.Append(Batch());
  SendAll();
  state_.OnAcknowledgement(2);
  state_.Disconnect(false, false);
  state_.Connect(kPosition);
  state_.Disconnect(/*unknown_session=*/true, false);
  EXPECT_EQ(state_.Connect(kPosition).session_id, "");
  state_.OnWelcome(WelcomeTo("b"));
  EXPECT_EQ(state_.session_id(), "b");
  EXPECT_EQ(SendAll(), (Sequences{1, 2}));
  EXPECT_EQ(state_.counts().acknowledged_sequence, 0U);
  EXPECT_EQ(state_.counts().sent_sequence, 2U);
}

TEST_F(SessionStateTest, ARefusedResumeBeginsANewSessionAndSendsNothingTwice) {
  Begin();
  state_.Append(Batch());
  state_.Append(Batch());
  SendAll();
  state_.Append(Batch());
  state_.Disconnect(false, false);
  EXPECT_EQ(state_.Connect(kPosition).session_id, "a");
  state_.Disconnect(false, /*refused=*/true);
  EXPECT_EQ(state_.Connect(kPosition).session_id, "");
  EXPECT_EQ(state_.counts().dropped_frame_count, 2U) << "session a may already contain them";
  state_.OnWelcome(WelcomeTo("b"));
  EXPECT_EQ(SendAll(), Sequences{1}) << "only the message that was never sent";
}

TEST_F(SessionStateTest, SendsNothingTwiceIfTheDaemonCannotReadTheOldSession) {
  Begin();
  state_.Append(Batch(1, 3));
  state_.Append(Batch(4, 4));
  SendAll();
  state_.Disconnect(false, false);
  state_.Append(Batch(5, 5));
  state_.Connect(kPosition);
  protocol::Welcome welcome = WelcomeTo("b");
  welcome.priors_unavailable = true;
  state_.OnWelcome(welcome);
  EXPECT_EQ(SendAll(), Sequences{1}) << "only the message that was never sent";
  EXPECT_EQ(state_.counts().dropped_frame_count, 2U);
}

TEST_F(SessionStateTest, AWelcomeThatDoesNotResumeBeginsANewSession) {
  Begin();
  state_.Append(Batch());
  state_.Append(Batch());
  SendAll();
  state_.OnAcknowledgement(1);
  state_.Disconnect(false, false);
  state_.Connect(kPosition);
  state_.OnWelcome(WelcomeTo("b", false, 77));
  EXPECT_EQ(SendAll(), Sequences{1});
}

TEST_F(SessionStateTest, AWelcomeThatResumesAnotherSessionBeginsANewOne) {
  Begin();
  state_.Append(Batch());
  SendAll();
  state_.Disconnect(false, false);
  state_.Connect(kPosition);
  state_.OnWelcome(WelcomeTo("other", true, 1));
  EXPECT_EQ(SendAll(), Sequences{1});
}

TEST_F(SessionStateTest, DropsRefusedMessagesSoThatTheyAreNotRefusedAgain) {
  Begin();
  state_.Append(Batch());
  SendAll();
  state_.Append(Batch());
  state_.Disconnect(false, /*refused=*/true);
  EXPECT_EQ(state_.counts().dropped_frame_count, 1U);
  state_.Connect(kPosition);
  state_.OnWelcome(WelcomeTo("a", true, 0));
  EXPECT_EQ(SendAll(), Sequences{2});
}

TEST_F(SessionStateTest, ResumedElsewhereSendsNothingTwice) {
  Begin();
  state_.Append(Batch());
  SendAll();
  state_.Append(Batch());
  state_.Disconnect(false, false);
  state_.Connect(kPosition);
  state_.ForgetSession();
  state_.Disconnect(false, false);
  EXPECT_EQ(state_.session_id(), "");
  EXPECT_EQ(state_.counts().dropped_frame_count, 1U);
  state_.Connect(kPosition);
  state_.OnWelcome(WelcomeTo("other", false, 0));
  EXPECT_EQ(SendAll(), Sequences{1}) << "the message that was never sent, with a new number";
}

TEST_F(SessionStateTest, KeepsItsEvidenceWhenItsFirstHelloIsRefused) {
  state_.Append(Batch());
  state_.Connect(kPosition);
  state_.Disconnect(false, /*refused=*/true);
  state_.Connect(kPosition);
  state_.OnWelcome(WelcomeTo("a", true, 0));
  EXPECT_EQ(SendAll(), Sequences{1});
}

TEST_F(SessionStateTest, IgnoresAcknowledgementsOfUnsentMessages) {
  Begin();
  for (int i = 0; i < 3; ++i) state_.Append(Batch());
  state_.MarkSent();
  state_.OnAcknowledgement(2);
  state_.OnAcknowledgement(1000);
  EXPECT_EQ(state_.counts().acknowledged_sequence, 0U);
  EXPECT_EQ(SendAll(), (Sequences{2, 3}));
}

TEST_F(SessionStateTest, IgnoresAWelcomeThatAcknowledgesUnsentMessages) {
  Begin();
  state_.Append(Batch());
  SendAll();
  state_.Append(Batch());
  state_.Disconnect(false, false);
  state_.Connect(kPosition);
  state_.OnWelcome(WelcomeTo("a", true, 2));
  EXPECT_EQ(SendAll(), (Sequences{1, 2}));
}

TEST_F(SessionStateTest, IgnoresAcknowledgementsOfTheFormerSession) {
  Begin();
  for (int i = 0; i < 3; ++i) state_.Append(Batch());
  SendAll();
  state_.Disconnect(false, false);
  state_.Connect(kPosition);
  state_.OnWelcome(WelcomeTo("b"));
  state_.OnAcknowledgement(3);
  EXPECT_EQ(SendAll(), (Sequences{1, 2, 3}));
}

}  // namespace
}  // namespace sweepstake
