#include "engine_client/cli/game/machine_class.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

namespace sweepstake::cli {
namespace {

TEST(MachineClass, NamesSystemProcessorAndThreadsInLowerCase) {
  const std::string name = MachineClass();
  EXPECT_THAT(name, testing::MatchesRegex("[a-z0-9_.]+-[a-z0-9_.]+-[0-9]+"));
  EXPECT_THAT(name, testing::EndsWith("-" + std::to_string(std::thread::hardware_concurrency())));
  EXPECT_EQ(MachineClass(), name);
}

}  // namespace
}  // namespace sweepstake::cli
