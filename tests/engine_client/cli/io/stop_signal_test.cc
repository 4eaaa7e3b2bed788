#include "engine_client/cli/io/stop_signal.h"

#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>

namespace sweepstake::cli {
namespace {

// The state is the process's, so each test has a process of its own.
TEST(StopSignalDeathTest, TheFirstSignalIsAQuestionAndTheSecondEndsTheProcess) {
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

TEST(StopSignalDeathTest, TermAsksToo) {
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
