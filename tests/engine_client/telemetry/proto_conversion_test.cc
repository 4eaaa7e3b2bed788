#include "engine_client/telemetry/conversion/proto_conversion.h"

#include <gtest/gtest.h>

#include <limits>

namespace sweepstake {
namespace {

TEST(ProtoConversion, ReturnsADescriptorUnchanged) {
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

TEST(ProtoConversion, ReturnsAPriorRecordUnchanged) {
  const PriorRecord record = {.key = {.project = "a",
                                      .scene = "b",
                                      .measured_by = "lane",
                                      .arm = "d",
                                      .backend_version = 1,
                                      .machine_class = "e",
                                      .reward_version = 2,
                                      .regime = "13/-4/0"},
                              .source_id = "f",
                              .source_sequence = 3,
                              .evidence = {4, 5, 6, 7},
                              .build = "g",
                              .last_seen_unix_s = 8};
  EXPECT_EQ(FromProto(ToProto(record)), record);
}

TEST(ProtoConversion, AcceptsOnlyValidPosteriors) {
  v1::BetaPosterior posterior;
  posterior.set_alpha(3);
  EXPECT_FALSE(FromProto(posterior, "SAP"));
  posterior.set_beta(std::numeric_limits<double>::infinity());
  EXPECT_FALSE(FromProto(posterior, "SAP"));
  posterior.set_beta(4);
  const auto belief = FromProto(posterior, "SAP");
  ASSERT_TRUE(belief);
  EXPECT_EQ(belief->arm, "SAP");
  EXPECT_EQ(belief->alpha, 3);
  EXPECT_EQ(belief->beta, 4);
}

}  // namespace
}  // namespace sweepstake
