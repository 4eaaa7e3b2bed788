// Tests the warning about a database that is nearly full.
#include "server/host/space_warning.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "server/daemon.h"
#include "tests/support/http_exchange.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr uint64_t kMaxBytes = uint64_t{4'096} << 20;
constexpr uint64_t kThreeQuarters = uint64_t{3'072} << 20;

TEST(SpaceWarningTest, ComesAboveThreeQuartersWithAdvice) {
  SpaceWarning warning;
  EXPECT_EQ(warning.Look(0, kMaxBytes, {}), std::nullopt);
  EXPECT_EQ(warning.Look(kThreeQuarters, kMaxBytes, {}), std::nullopt);
  EXPECT_THAT(warning.Look(kThreeQuarters + 4'096, kMaxBytes, {}).value(),
              AllOf(HasSubstr("3072 MiB of the 4096 MiB"), HasSubstr("raise database_mb"),
                    HasSubstr("revoke the token"), HasSubstr("sweepstake sessions watch")));
}

TEST(SpaceWarningTest, ComesOnceAnHour) {
  SpaceWarning warning;
  const SpaceWarning::TimePoint start{};
  const auto warns = [&](uint64_t used_bytes, std::chrono::seconds after) {
    return warning.Look(used_bytes, kMaxBytes, start + after).has_value();
  };
  using std::chrono::seconds;
  EXPECT_TRUE(warns(kMaxBytes, seconds(0)));
  EXPECT_FALSE(warns(kMaxBytes, seconds(3'599)));
  EXPECT_TRUE(warns(kMaxBytes, seconds(3'600)));
  EXPECT_FALSE(warns(kThreeQuarters, seconds(7'200)));
  EXPECT_TRUE(warns(kMaxBytes, seconds(7'201)));
}

// Runs a daemon with this maximum size of its database until /metrics shows the used size. Returns
// its log.
std::string LogOfADaemon(uint64_t max_bytes) {
  const test_support::TemporaryDirectory directory;
  Config config;
  config.listen = "127.0.0.1:0";
  config.http = "127.0.0.1:0";
  config.data = directory.path() / "data";
  config.log_level = "warn";
  config.database_bytes = max_bytes;
  config.audit.bytes = 0;
  sessions::SteadyLoopClock clock;
  ::testing::internal::CaptureStderr();
  const auto daemon = *Daemon::Start(config, clock);
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  std::string metrics;
  do {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    metrics = test_support::Get(daemon->http_port(), "/metrics").body;
  } while (metrics.find("\nsweepstake_store_used_size_bytes 0\n") != std::string::npos &&
           std::chrono::steady_clock::now() < deadline);
  EXPECT_THAT(metrics, HasSubstr("\nsweepstake_store_used_size_bytes "));
  EXPECT_THAT(metrics, Not(HasSubstr("\nsweepstake_store_used_size_bytes 0\n")));
  daemon->Drain();
  return ::testing::internal::GetCapturedStderr();
}

TEST(DaemonSpaceTest, TheDaemonLogsTheWarning) {
  EXPECT_THAT(LogOfADaemon(/*max_bytes=*/1 << 16),
              AllOf(HasSubstr("warn"), HasSubstr("priors.db: "), HasSubstr("raise database_mb")));
  EXPECT_THAT(LogOfADaemon(kMaxBytes), Not(HasSubstr("database_mb")));
}

}  // namespace
}  // namespace sweepstake::server
