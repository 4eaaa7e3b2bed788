#include "server/exit_guard.h"

#include <gtest/gtest.h>

namespace sweepstake::server {
namespace {

using std::chrono::hours;
using std::chrono::milliseconds;

TEST(ExitGuardDeathTest, EndsAProcessThatDoesNotEndByItself) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_EXIT(
      {
        const ExitGuard guard(milliseconds(1), 4, "the disk does not answer");
        std::this_thread::sleep_for(hours(1));
      },
      ::testing::ExitedWithCode(4), "the disk does not answer");
}

TEST(ExitGuard, LetsAnEndInTimePass) { const ExitGuard guard(hours(1), 4, "too late"); }

}  // namespace
}  // namespace sweepstake::server
