// logs/ contains logs of real games with a real daemon, made on Linux x86-64 (logs/make.sh). These
// tests replay them and expect the same bits on every platform.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "engine_client/decider/audit/rederive.h"

namespace sweepstake::decision {
namespace {

class AuditLogOfARealGame : public ::testing::TestWithParam<std::string> {};

TEST_P(AuditLogOfARealGame, ReplaysBitForBit) {
  const std::filesystem::path path =
      std::filesystem::path(SWEEPSTAKE_LOGS_DIR) / (GetParam() + ".csv");
  std::ifstream file(path, std::ios::binary);
  ASSERT_TRUE(file) << path;
  const std::string csv{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  const AuditReport report = RederiveCsv(csv);
  EXPECT_FALSE(report.difference)
      << report.difference->Text()
      << "\n"
         "If decisions were meant to change, make new logs with logs/make.sh";
  EXPECT_GE(report.decision_count, 30u);
}

INSTANTIATE_TEST_SUITE_P(Policies, AuditLogOfARealGame, ::testing::Values("paper", "adaptive"),
                         [](const auto& instance) { return instance.param; });

}  // namespace
}  // namespace sweepstake::decision
