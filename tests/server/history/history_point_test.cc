// Tests the sums of points.
#include "server/history/history_point.h"

#include <gtest/gtest.h>

#include <limits>

namespace sweepstake::history {
namespace {

SessionReport Report(std::vector<std::string> arms, int64_t start_ms) {
  const size_t arm_count = arms.size();
  SessionReport report = {
      .scene = {"game", "harbour", "", 1}, .build = "12", .session = "a", .arms = std::move(arms)};
  sessions::SessionUse& use = report.use;
  use.unix_start_ms = start_ms;
  use.unix_end_ms = start_ms + 10'000;
  use.frames.Add(16'000'000, 100'000, 4'096);
  use.is_first = true;
  use.active_frame_counts.resize(arm_count);
  use.active_frame_counts[0] = 1;
  use.measured.frame_count = 1;
  use.measured.ran_us = 100;
  use.measured.arm_us.assign(arm_count, 120);
  use.measured.known_frame_counts.assign(arm_count, 1);
  use.measured.known_frame_counts[0] = 0;
  use.initial_arm = static_cast<uint32_t>(arm_count - 1);
  use.switch_count = 2;
  return report;
}

TEST(HistoryPointTest, ArmsAreOrderedByName) {
  const v1::HistoryPoint point = PointOf(Report({"SAP", "DBVT", "KDTree"}, 5'000));
  ASSERT_EQ(point.arms_size(), 3);
  EXPECT_EQ(point.arms(0).arm(), "DBVT");
  EXPECT_EQ(point.arms(1).arm(), "KDTree");
  EXPECT_EQ(point.arms(2).arm(), "SAP");
  EXPECT_EQ(point.arms(2).active_frame_count(), 1U);
  EXPECT_EQ(point.arms(0).active_frame_count(), 0U);
  EXPECT_EQ(point.arms(0).would_take_us(), 120);
}

TEST(HistoryPointTest, SumsHaveAllFields) {
  v1::HistoryPoint sum;
  Add(PointOf(Report({"SAP", "KDTree"}, 20'000)), sum);
  Add(PointOf(Report({"Grid", "SAP"}, 5'000)), sum);
  EXPECT_EQ(sum.unix_ms(), 5'000);
  EXPECT_EQ(sum.end_unix_ms(), 30'000);
  EXPECT_EQ(sum.frame_count(), 2U);
  EXPECT_EQ(sum.ran_us(), 200);
  EXPECT_EQ(sum.initial_us(), 240);
  EXPECT_EQ(sum.initial_known_frame_count(), 2U);
  EXPECT_EQ(sum.switch_count(), 4U);
  ASSERT_EQ(sum.frame_time_ns().counts_size(), 1);
  EXPECT_EQ(sum.frame_time_ns().counts(0), 2U);
  EXPECT_EQ(sum.frame_time_ns().bucket_steps(0), sessions::LogHistogram::BucketOf(16'000'000));
  EXPECT_EQ(sum.detection_time_ns().counts(0), 2U);
  EXPECT_EQ(sum.native_bytes().counts(0), 2U);
  EXPECT_EQ(sum.session_count(), 2U);
  ASSERT_EQ(sum.arms_size(), 3);
  EXPECT_EQ(sum.arms(0).frame_count(), 1U) << "only one session has Grid";
  EXPECT_EQ(sum.arms(2).frame_count(), 2U);
  EXPECT_EQ(sum.arms(2).would_take_us(), 240);
  EXPECT_EQ(sum.arms(2).known_frame_count(), 1U);
}

TEST(HistoryPointTest, ReportsAreAddedToSceneBuildAndSession) {
  HistoryBatch batch;
  batch.reports = {Report({"SAP"}, 5'000), Report({"SAP"}, 6'000)};
  batch.reports[1].build = "13";
  batch.reports[1].session = "b";
  batch.activities[batch.reports[0].scene].set_active_arm("SAP");
  const std::vector<HistoryEntry> entries = EntriesOf(batch);
  ASSERT_EQ(entries.size(), 5U);
  EXPECT_EQ(entries[0].first.kind, v1::HISTORY_KIND_SCENE);
  EXPECT_EQ(entries[0].second.frame_count(), 2U);
  EXPECT_EQ(entries[0].second.activity().active_arm(), "SAP");
  EXPECT_EQ(entries[1].first.build, "12");
  EXPECT_EQ(entries[2].first.build, "13");
  EXPECT_EQ(entries[2].second.frame_count(), 1U);
  EXPECT_FALSE(entries[2].second.has_activity());
  EXPECT_EQ(entries[3].first.session, "a");
  EXPECT_EQ(entries[4].first.session, "b");
}

TEST(HistoryPointTest, TheActivityIsThatOfTheLatestPoint) {
  v1::HistoryPoint early, late, sum;
  early.set_unix_ms(1);
  early.set_end_unix_ms(2);
  early.mutable_activity()->set_active_arm("SAP");
  late.set_unix_ms(3);
  late.set_end_unix_ms(4);
  late.mutable_activity()->set_active_arm("Grid");
  Add(late, sum);
  Add(early, sum);
  EXPECT_EQ(sum.activity().active_arm(), "Grid");
}

TEST(HistoryPointTest, AHistogramKeepsItsHighestBuckets) {
  v1::HistoryPoint sum;
  for (uint32_t bucket = 1; bucket <= 100; ++bucket) {
    v1::HistoryPoint point;
    point.mutable_frame_time_ns()->add_bucket_steps(bucket);
    point.mutable_frame_time_ns()->add_counts(1);
    Add(point, sum);
  }
  const v1::LogHistogram& histogram = sum.frame_time_ns();
  ASSERT_EQ(histogram.counts_size(), static_cast<int>(sessions::LogHistogram::kMaxBuckets));
  EXPECT_EQ(histogram.bucket_steps(0), 37U);
  EXPECT_EQ(histogram.counts(0), 37U) << "the lowest buckets are joined";
}

TEST(HistoryPointTest, CountsBeyond32BitsAreHalved) {
  v1::HistoryPoint point;
  for (const uint32_t count : {std::numeric_limits<uint32_t>::max(), 1'000u}) {
    point.mutable_frame_time_ns()->add_bucket_steps(8);
    point.mutable_frame_time_ns()->add_counts(count);
  }
  v1::HistoryPoint sum = point;
  Add(point, sum);
  EXPECT_EQ(sum.frame_time_ns().counts(0), std::numeric_limits<uint32_t>::max());
  EXPECT_EQ(sum.frame_time_ns().counts(1), 1'000U);
}

}  // namespace
}  // namespace sweepstake::history
