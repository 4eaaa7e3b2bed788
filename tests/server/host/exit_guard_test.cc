#include "server/host/exit_guard.h"

#include <gtest/gtest.h>

#include <cstdio>

namespace sweepstake::server {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;

TEST(ExitGuardDeathTest, ExitsAProcessThatDoesNotEndInTime) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        const ExitGuard guard(milliseconds(1), 4, "the disk does not answer", [] { return false; });
        std::this_thread::sleep_for(hours(1));
      },
      ::testing::ExitedWithCode(4), "the disk does not answer");
}

TEST(ExitGuardDeathTest, WaitsAgainWhileTheProcessMustWait) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        int asked_count = 0;
        const ExitGuard guard(milliseconds(1), 4, "too late", [&] {
          std::fprintf(stderr, "asked ");
          return ++asked_count < 3;
        });
        std::this_thread::sleep_for(hours(1));
      },
      ::testing::ExitedWithCode(4), "^asked asked asked too late");
}

TEST(ExitGuard, DoesNothingIfTheProcessEndsInTime) {
  const ExitGuard guard(hours(1), 4, "too late", [] { return false; });
}

}  // namespace
}  // namespace sweepstake::server
