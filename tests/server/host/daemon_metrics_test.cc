// Tests the metrics of the daemon.
#include "server/host/daemon_metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <set>

#include "tests/support/temporary_directory.h"

namespace sweepstake::server {
namespace {

using std::chrono::milliseconds;
using ::testing::EndsWith;
using ::testing::StartsWith;

class DaemonMetricsTest : public ::testing::Test {
 protected:
  // Returns the first metric of each family, by name.
  std::map<std::string, prometheus::ClientMetric> Collect(bool store_healthy = true) {
    std::map<std::string, prometheus::ClientMetric> metrics;
    for (const auto& family : metrics_.Collect(counters_, events_,
                                               {.healthy = store_healthy,
                                               .queued_commit_count = 7,
                                               .queued_read_count = 9,
                                               .database = database_},
                                               figures_, webhook_)) {
      EXPECT_TRUE(metrics.emplace(family.name, family.metric.front()).second) << family.name;
    }
    return metrics;
  }

  test_support::TemporaryDirectory directory_;
  std::filesystem::path database_ = directory_.path() / "priors.db";
  rpc::Counters counters_;
  web::EventCounters events_;
  alerts::AlertFigures figures_;
  alerts::WebhookCounters webhook_;
  DaemonMetrics metrics_{"1.2.3"};
};

TEST_F(DaemonMetricsTest, EveryCounterIsShownOnce) {
  auto* counters = reinterpret_cast<std::atomic<uint64_t>*>(&counters_);
  const auto reasons = static_cast<size_t>(counters_.error_counts.data() - counters);
  std::multiset<double> expected;
  for (size_t i = 0; i < sizeof(counters_) / sizeof(*counters); ++i) {
    // Some numbers between two reasons are not used by any reason.
    if (i >= reasons && !v1::ErrorReason_IsValid(static_cast<int>(i - reasons))) continue;
    counters[i] = (i + 1) * 1'000'003;
    expected.insert(static_cast<double>((i + 1) * 1'000'003));
  }
  std::multiset<double> shown;
  for (const auto& family :
       metrics_.Collect(counters_, events_, {.database = database_}, figures_, webhook_)) {
    for (const prometheus::ClientMetric& metric : family.metric) {
      for (const double value : {metric.counter.value, metric.gauge.value}) {
        if (expected.contains(value)) shown.insert(value);
      }
    }
  }
  EXPECT_EQ(shown, expected);
}

TEST_F(DaemonMetricsTest, SuspendedFramesAreShown) {
  counters_.suspended_frame_count = 3;
  EXPECT_EQ(Collect().at("sweepstake_suspended_frames_total").counter.value, 3);
}

TEST_F(DaemonMetricsTest, BatchesWithInvalidBoxesAreShown) {
  counters_.invalid_box_batch_count = 4;
  EXPECT_EQ(Collect().at("sweepstake_invalid_box_batches_total").counter.value, 4);
}

TEST_F(DaemonMetricsTest, NamesFollowTheConventions) {
  const std::map<std::string, size_t> series_counts = {
      {"sweepstake_errors_total", static_cast<size_t>(v1::ErrorReason_descriptor()->value_count())},
      {"sweepstake_alerts", 2 * alerts::kRuleNames.size()},
      {"sweepstake_rejected_frames_total", sessions::kRejectionReasonNames.size()},
      {"sweepstake_rejected_shadow_samples_total", sessions::kRejectionReasonNames.size()}};
  for (const auto& family :
       metrics_.Collect(counters_, events_, {.database = database_}, figures_, webhook_)) {
    const bool is_of_process = family.name.starts_with("process_");
    const bool is_counter = family.type == prometheus::MetricType::Counter;
    EXPECT_THAT(family.name, StartsWith(is_of_process ? "process_" : "sweepstake_"));
    EXPECT_THAT(family.name, EndsWith(is_counter ? "_total" : ""));
    EXPECT_THAT(family.help, EndsWith("."));
    const auto count = series_counts.find(family.name);
    EXPECT_EQ(family.metric.size(), count == series_counts.end() ? 1 : count->second)
        << family.name << ": no label may add series to it";
  }
}

TEST_F(DaemonMetricsTest, DurationsAreHistogramsInSeconds) {
  metrics_.OnCommit(milliseconds(4));
  metrics_.OnRead(milliseconds(5));
  metrics_.OnSync(milliseconds(3));
  metrics_.OnSync(milliseconds(30));
  metrics_.OnTimer(milliseconds(2));
  const auto shown = Collect();
  const auto& syncs = shown.at("sweepstake_store_fsync_duration_seconds").histogram;
  EXPECT_EQ(syncs.sample_count, 2u);
  EXPECT_NEAR(syncs.sample_sum, 0.033, 1e-9);
  EXPECT_EQ(shown.at("sweepstake_store_commit_duration_seconds").histogram.sample_count, 1u);
  EXPECT_NEAR(shown.at("sweepstake_store_read_duration_seconds").histogram.sample_sum, 0.005, 1e-9);
  EXPECT_NEAR(shown.at("sweepstake_decision_loop_lateness_seconds").histogram.sample_sum, 0.002,
              1e-9);
}

TEST_F(DaemonMetricsTest, TheStoreAndItsLogAreShown) {
  EXPECT_EQ(Collect().at("sweepstake_store_wal_size_bytes").gauge.value, 0);
  std::ofstream(database_.string() + "-wal") << "12345";
  EXPECT_EQ(Collect().at("sweepstake_store_wal_size_bytes").gauge.value, 5);
  EXPECT_EQ(Collect(true).at("sweepstake_store_healthy").gauge.value, 1);
  EXPECT_EQ(Collect(false).at("sweepstake_store_healthy").gauge.value, 0);
  EXPECT_EQ(Collect().at("sweepstake_store_queued_commits").gauge.value, 7);
  EXPECT_EQ(Collect().at("sweepstake_store_queued_reads").gauge.value, 9);
}

TEST_F(DaemonMetricsTest, UsedAndMaximumSizeOfTheStoreAreShown) {
  metrics_.SetMaxStoreBytes(4'096);
  metrics_.SetUsedStoreBytes(3'072);
  EXPECT_EQ(Collect().at("sweepstake_store_max_size_bytes").gauge.value, 4'096);
  EXPECT_EQ(Collect().at("sweepstake_store_used_size_bytes").gauge.value, 3'072);
}

TEST_F(DaemonMetricsTest, TheBuildIsNamed) {
  const auto shown = Collect();
  const prometheus::ClientMetric& info = shown.at("sweepstake_build_info");
  EXPECT_EQ(info.gauge.value, 1);
  ASSERT_EQ(info.label.size(), 1u);
  EXPECT_EQ(info.label[0].name, "version");
  EXPECT_EQ(info.label[0].value, "1.2.3");
}

}  // namespace
}  // namespace sweepstake::server
