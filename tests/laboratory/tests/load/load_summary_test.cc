// Tests that the figures of a load run contain the measured values and omit the others.
#include "tests/laboratory/load/load_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace sweepstake::cli {
namespace {

using ::testing::HasSubstr;

TEST(LoadSummary, GivesRatesAndQuantiles) {
  LoadPlan plan;
  plan.stream_count = 20;
  plan.batch_frames = 60;
  LoadResult result;
  result.measured_batch_count = 100;
  result.measured_s = 5;
  result.decision_latency_ms = {1, 2, 3};
  result.server_cpu_s = 0.25;
  const auto json = LoadJson(plan, result);
  EXPECT_EQ(json["streams"], 20);
  EXPECT_EQ(json["batches_per_s"], 20.0);
  EXPECT_EQ(json["frames_per_s"], 1200.0);
  EXPECT_EQ(json["decision_latency_ms_p50"], 2.0);
  EXPECT_EQ(json["decision_latency_ms_p99"], 3.0);
  EXPECT_EQ(json["server_cpu_s"], 0.25);
  EXPECT_THAT(LoadText(plan, result), HasSubstr("1200.00"));
}

TEST(LoadSummary, LeavesOutWhatWasNotMeasured) {
  LoadResult result;
  result.measured_s = 1;
  const auto json = LoadJson({}, result);
  for (const char* name :
       {"decision_latency_ms_p50", "tick_lateness_ms_p99", "reconnect_s", "server_cpu_s"}) {
    EXPECT_FALSE(json.contains(name)) << name;
  }
}

}  // namespace
}  // namespace sweepstake::cli
