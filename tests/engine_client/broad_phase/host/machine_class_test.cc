#include "sweepstake/machine_class.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <thread>

#include "engine_client/broad_phase/host/processor_name.h"
#include "sweepstake/simd.h"

namespace sweepstake {
namespace {

using testing::MatchesRegex;

TEST(MachineClass, NamesProcessorThreadsInstructionSetAndMemory) {
  const std::string end = "-" + std::to_string(std::thread::hardware_concurrency()) + "-" +
                          std::string(SimdTarget()) + "-[0-9]+g";
  EXPECT_THAT(MachineClass(), MatchesRegex("[a-z0-9]+(-[a-z0-9]+)*" + end));
  EXPECT_LE(MachineClass().size(), 128u);
  EXPECT_EQ(MachineClass(), MachineClass());
}

TEST(MachineClass, IsAnotherOneWithLesserInstructions) {
  const std::string target(SimdTarget());
  const std::string name = MachineClass();
  ASSERT_TRUE(UseSimdTarget("scalar").ok());
  EXPECT_THAT(MachineClass(), testing::HasSubstr("-scalar-"));
  ASSERT_TRUE(UseSimdTarget(target).ok());
  EXPECT_EQ(MachineClass(), name);
}

TEST(ProcessorName, IsOfPrintableCharacters) {
  EXPECT_FALSE(ProcessorName().empty());
  for (const char character : ProcessorName()) EXPECT_TRUE(character >= ' ' && character <= '~');
}

}  // namespace
}  // namespace sweepstake
