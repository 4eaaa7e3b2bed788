#include "engine_client/telemetry/proto_conversion.h"

#include <gtest/gtest.h>

#include <limits>

namespace sweepstake {
namespace {

TEST(ProtoConversion, RefusesAnArmTheSessionDoesNotHave) {
  v1::SwitchCommand command;
  command.set_command_id(4);
  command.set_arm(99);
  command.set_reason(v1::SWITCH_REASON_POLICY);
  const v1::SwitchOutcome outcome = RefusalToProto(command, 2, 3).switch_outcome();
  EXPECT_EQ(outcome.command_id(), 4U);
  EXPECT_EQ(outcome.arm(), 2U);
  EXPECT_EQ(outcome.switch_epoch(), 3U);
  EXPECT_FALSE(outcome.executed());
  EXPECT_EQ(outcome.reason(), v1::SWITCH_REASON_POLICY);
}

TEST(ProtoConversion, GivesADescriptorBackAsItWas) {
  const SceneDescriptor descriptor = {.object_count = 1,
                                      .density_ratio = 2,
                                      .size_spread = 3,
                                      .speed_mean = 4,
                                      .speed_spread = 5,
                                      .clustering_ratio = 6,
                                      .static_ratio = -1};
  const v1::SceneDescriptor message = ToProto(descriptor);
  EXPECT_FALSE(message.has_static_ratio());
  const SceneDescriptor back = FromProto(message);
  EXPECT_EQ(back.object_count, 1);
  EXPECT_EQ(back.density_ratio, 2);
  EXPECT_EQ(back.size_spread, 3);
  EXPECT_EQ(back.speed_mean, 4);
  EXPECT_EQ(back.speed_spread, 5);
  EXPECT_EQ(back.clustering_ratio, 6);
  EXPECT_EQ(back.static_ratio, -1);
}

TEST(ProtoConversion, GivesAPriorRecordBackAsItWas) {
  const PriorRecord record = {.project = "a",
                              .scene = "b",
                              .context_bucket = "c",
                              .arm = "d",
                              .backend_version = 1,
                              .machine_class = "e",
                              .reward_version = 2,
                              .source_id = "f",
                              .source_sequence = 3,
                              .alpha_increment = 4,
                              .beta_increment = 5,
                              .window_count = 6,
                              .bail_out_count = 7};
  const PriorRecord back = FromProto(ToProto(record));
  EXPECT_EQ(FormatPriors({&back, 1}), FormatPriors({&record, 1}));
}

TEST(ProtoConversion, RefusesWhatNoDaemonOfThisVersionSends) {
  v1::SwitchCommand command;
  EXPECT_FALSE(FromProto(command));
  command.set_reason(v1::SWITCH_REASON_MANUAL);
  ASSERT_TRUE(FromProto(command));
  EXPECT_EQ(FromProto(command)->reason, SwitchReason::kManual);

  v1::PosteriorSnapshot snapshot;
  snapshot.set_verdict(v1::VERDICT_TIE);
  snapshot.set_leader_arm(1);
  snapshot.set_leader_probability(0.5);
  ASSERT_TRUE(FromProto(snapshot, 2));
  EXPECT_EQ(FromProto(snapshot, 2)->verdict, Verdict::kTie);
  EXPECT_FALSE(FromProto(snapshot, 1));
  snapshot.set_leader_probability(std::numeric_limits<double>::quiet_NaN());
  EXPECT_FALSE(FromProto(snapshot, 2));
}

TEST(ProtoConversion, TakesPosteriorsOnlyWhereEachIsValidAndThereIsOnePerArm) {
  const std::vector<std::string> arms = {"Grid", "SAP"};
  v1::PosteriorSnapshot snapshot;
  snapshot.add_arms()->set_alpha(3);
  snapshot.mutable_arms(0)->set_beta(1);
  EXPECT_FALSE(FromProto(snapshot.arms(), arms));
  snapshot.add_arms()->set_alpha(2);
  EXPECT_FALSE(FromProto(snapshot.arms(), arms));
  snapshot.mutable_arms(1)->set_beta(4);
  const auto beliefs = FromProto(snapshot.arms(), arms);
  ASSERT_TRUE(beliefs);
  EXPECT_EQ((*beliefs)[1].arm, "SAP");
  EXPECT_EQ((*beliefs)[1].alpha, 2);
  EXPECT_EQ((*beliefs)[1].beta, 4);
}

}  // namespace
}  // namespace sweepstake
