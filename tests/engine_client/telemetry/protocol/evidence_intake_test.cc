#include "engine_client/telemetry/protocol/evidence_intake.h"

#include <gtest/gtest.h>

#include "engine_client/telemetry/protocol/wire.h"
#include "sweepstake/v1/telemetry.pb.h"

namespace sweepstake {
namespace {

class EvidenceIntakeTest : public ::testing::Test {
 protected:
  EvidenceIntakeTest() {
    state_.Connect({});
    protocol::Welcome welcome;
    welcome.session_id = "a";
    state_.OnWelcome(welcome);
  }

  FrameSample Frame(uint32_t flags = 0) {
    FrameSample sample{};
    sample.frame_index = next_index_++;
    sample.frame_time_ns = 1000;
    sample.flags = flags;
    queue_.OnFrame(sample);
    return sample;
  }

  std::vector<v1::StreamTelemetryRequest> Sent() {
    std::vector<v1::StreamTelemetryRequest> requests;
    while (const auto* next = state_.Next()) {
      EXPECT_TRUE(requests.emplace_back().ParseFromString(
          protocol::Numbered(next->sequence, next->evidence.message)));
      state_.MarkSent();
    }
    return requests;
  }

  SampleQueue queue_{64};
  ResumableSession state_{protocol::Hello(), 4};
  EvidenceIntake intake_{queue_, state_, {.interval_ns = 100, .frames = 3, .bytes = 16384}};
  uint64_t next_index_ = 0;
};

TEST_F(EvidenceIntakeTest, SendsABatchWhenItIsFullOrDue) {
  for (int i = 0; i < 4; ++i) Frame();
  EXPECT_TRUE(intake_.Pump(0));
  auto sent = Sent();
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_EQ(sent[0].frame_batch().frame_time_ns_size(), 3);
  EXPECT_TRUE(intake_.Pump(99));
  EXPECT_TRUE(Sent().empty());
  EXPECT_TRUE(intake_.Pump(100));
  sent = Sent();
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_EQ(sent[0].frame_batch().frame_time_ns_size(), 1);
}

TEST_F(EvidenceIntakeTest, ReportsABailOutAtOnceAfterTheFramesBeforeIt) {
  Frame();
  Frame(kFrameBailOut);
  Frame();
  intake_.Pump(0);
  const auto sent = Sent();
  ASSERT_EQ(sent.size(), 2U);
  EXPECT_EQ(sent[0].frame_batch().frame_time_ns_size(), 2);
  EXPECT_EQ(sent[1].bail_out().frame_index(), 1U);
  EXPECT_EQ(sent[1].bail_out().flags(), uint32_t{kFrameBailOut});
}

TEST_F(EvidenceIntakeTest, KeepsTheOrderOfSwitchesModeChangesAndFrames) {
  Frame();
  queue_.OnSwitch({.command_id = 9,
                   .arm = 1,
                   .switch_epoch = 2,
                   .rebuild_time_ns = 3,
                   .settling_cost_ns = 4,
                   .reason = SwitchReason::kExploration,
                   .executed = 1});
  Frame();
  queue_.OnModeChange({.mode = Mode::kManual, .active_arm = 1});
  intake_.Pump(0);
  const auto sent = Sent();
  ASSERT_EQ(sent.size(), 4U);
  EXPECT_TRUE(sent[0].has_frame_batch());
  const v1::SwitchOutcome& outcome = sent[1].switch_outcome();
  EXPECT_EQ(outcome.command_id(), 9U);
  EXPECT_EQ(outcome.arm(), 1U);
  EXPECT_EQ(outcome.switch_epoch(), 2U);
  EXPECT_EQ(outcome.rebuild_time_ns(), 3U);
  EXPECT_EQ(outcome.settling_cost_ns(), 4U);
  EXPECT_EQ(outcome.reason(), v1::SWITCH_REASON_EXPLORATION);
  EXPECT_TRUE(outcome.executed());
  EXPECT_TRUE(sent[2].has_frame_batch());
  EXPECT_EQ(sent[3].mode_change().mode(), v1::MODE_MANUAL);
}

TEST_F(EvidenceIntakeTest, ReportsACommandThatWasNotExecuted) {
  queue_.OnSwitch({.command_id = 9, .executed = 0});
  intake_.Pump(0);
  const auto sent = Sent();
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_FALSE(sent[0].switch_outcome().executed());
}

TEST_F(EvidenceIntakeTest, SendsShadowSamplesWithTheNextBatches) {
  ShadowSample sample{};
  for (sample.arm = 0; sample.arm < 70; ++sample.arm) queue_.OnShadow(sample);
  EXPECT_TRUE(intake_.Pump(0));
  EXPECT_TRUE(Sent().empty());
  for (int i = 0; i < 3; ++i) Frame();
  intake_.Pump(0);
  auto sent = Sent();
  ASSERT_EQ(sent.size(), 1U);
  ASSERT_EQ(sent[0].frame_batch().shadow_samples_size(), 64);
  EXPECT_EQ(sent[0].frame_batch().shadow_samples(8).arm(), 8U);
  for (int i = 0; i < 3; ++i) Frame();
  intake_.Pump(0);
  sent = Sent();
  ASSERT_EQ(sent.size(), 1U);
  EXPECT_EQ(sent[0].frame_batch().shadow_samples_size(), 6);
}

TEST_F(EvidenceIntakeTest, PausesWhileTheSessionIsFullSoThatTheQueueDropsFrames) {
  for (int i = 0; i < 12; ++i) Frame();
  EXPECT_FALSE(intake_.Pump(0));
  EXPECT_TRUE(state_.full());
  for (int i = 0; i < 100; ++i) Frame();
  EXPECT_FALSE(intake_.Pump(0));
  EXPECT_EQ(queue_.dropped_frame_count(), 100U - 64U);
  Sent();
  state_.OnAcknowledgement(4);
  intake_.Pump(0);
  EXPECT_EQ(Sent()[0].frame_batch().dropped_frame_count(), 36U);
}

}  // namespace
}  // namespace sweepstake
