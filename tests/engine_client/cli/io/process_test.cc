#include "engine_client/cli/io/process.h"

#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>

namespace sweepstake::cli {
namespace {

// The state belongs to the process, so each test runs in its own process.
TEST(StopSignalDeathTest, TheFirstSignalSetsTheFlagAndTheSecondEndsTheProcess) {
  EXPECT_EXIT(
      {
        InstallStopSignal();
        if (StopRequested()) std::_Exit(1);
        std::raise(SIGINT);
        if (!StopRequested()) std::_Exit(2);
        std::raise(SIGINT);
        std::_Exit(3);
      },
      testing::KilledBySignal(SIGINT), "");
}

TEST(StopSignalDeathTest, SigtermSetsTheFlagToo) {
  EXPECT_EXIT(
      {
        InstallStopSignal();
        std::raise(SIGTERM);
        std::_Exit(StopRequested() ? 0 : 1);
      },
      testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace sweepstake::cli
