#include "engine_client/cli/scene_timing.h"

#include <gtest/gtest.h>

#include <sstream>

#include "engine_client/cli/scene_choice.h"
#include "engine_client/cli/text_table.h"

namespace sweepstake::cli {
namespace {

TEST(Median, IsTheMiddleOrTheMeanOfTheTwoMiddleOnes) {
  EXPECT_EQ(Median({1, 2, 9}), 2);
  EXPECT_EQ(Median({1, 2, 4, 9}), 3);
  EXPECT_EQ(Median({5}), 5);
}

TEST(Quantile, IsTheNearestRank) {
  std::vector<double> values;
  for (int i = 1; i <= 200; ++i) values.push_back(i);
  EXPECT_EQ(Quantile(values, 0.99), 198);
  EXPECT_EQ(Quantile(values, 0), 1);
  EXPECT_EQ(Quantile(values, 1), 200);
  EXPECT_EQ(Quantile({7}, 0.99), 7);
}

TEST(TimeScene, MeasuresTheFramesAfterTheWarmUpAndTheirPairs) {
  const auto scene = std::move(*OpenScene({"suite-b", 1000, 1}));
  const auto arm = std::move(*MakeBroadPhase("BruteForce"));
  uint64_t steps = 0;
  const ArmTiming timing = TimeScene(*scene, *arm, 20, 120, [&](uint64_t step) { steps = step; });
  EXPECT_EQ(steps, 140U);
  EXPECT_EQ(scene->frame_index(), 140U);
  EXPECT_EQ(timing.frame_count, 120U);
  // The reference suite's table: frames 21 to 140 of B at 1,000 objects.
  EXPECT_NEAR(timing.pairs_mean, 1379, 0.5);
  EXPECT_GT(timing.aabb_checks_mean, 0);
  EXPECT_GT(timing.bytes, 0U);
  EXPECT_LE(timing.ms_min, timing.ms_median);
  EXPECT_LE(timing.ms_median, timing.ms_p99);
}

TEST(TextTable, AlignsNumbersToTheRightAndWordsToTheLeft) {
  TextTable table({"arm", "ms"});
  table.AddRow({"SAP", "1.25"});
  table.AddRow({"AxisSweep", "10.50"});
  std::ostringstream out;
  table.Print(out);
  EXPECT_EQ(out.str(), "arm           ms\nSAP         1.25\nAxisSweep  10.50\n");
}

}  // namespace
}  // namespace sweepstake::cli
