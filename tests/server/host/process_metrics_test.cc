#include "server/host/daemon_metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <ctime>
#include <map>
#include <string>

namespace sweepstake::server {
namespace {

using ::testing::AllOf;
using ::testing::Ge;
using ::testing::Gt;
using ::testing::Le;

std::map<std::string, double> ProcessValues() {
  std::map<std::string, double> values;
  for (const auto& family : ProcessFamilies()) {
    const auto& metric = family.metric.front();
    values[family.name] =
        family.type == prometheus::MetricType::Counter ? metric.counter.value : metric.gauge.value;
  }
  return values;
}

TEST(ProcessMetricsTest, TheValuesDescribeThisProcess) {
  const auto values = ProcessValues();
  const auto now = static_cast<double>(std::time(nullptr));
  EXPECT_THAT(values.at("process_start_time_seconds"), AllOf(Gt(now - 86'400), Le(now + 60)));
  EXPECT_THAT(values.at("process_resident_memory_bytes"), Gt(1e6));
  EXPECT_THAT(values.at("process_cpu_seconds_total"), Ge(0));
  EXPECT_THAT(values.at("process_max_fds"), Ge(values.at("process_open_fds")));
}

TEST(ProcessMetricsTest, AnOpenDescriptorIsCounted) {
  const double before = ProcessValues().at("process_open_fds");
  const int file = dup(STDERR_FILENO);
  EXPECT_EQ(ProcessValues().at("process_open_fds"), before + 1);
  close(file);
}

}  // namespace
}  // namespace sweepstake::server
