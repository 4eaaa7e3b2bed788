#include "sweepstake/machine_class.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <thread>

#include "engine_client/broad_phase/host/processor_name.h"
#include "sweepstake/simd.h"

namespace sweepstake {
namespace {

TEST(MachineClass, ContainsProcessorThreadsInstructionSetAndMemory) {
  const std::string name = MachineClass();
  const std::string middle = "-" + std::to_string(std::thread::hardware_concurrency()) + "-" +
                             std::string(SimdTarget()) + "-";
  const size_t at = name.find(middle);
  ASSERT_NE(at, std::string::npos) << name;
  EXPECT_GT(at, 0u) << "the name begins with the processor";
  const std::string memory = name.substr(at + middle.size());
  EXPECT_TRUE(memory.ends_with('g')) << name;
  EXPECT_GT(std::stoi(memory), 0) << name;
  EXPECT_EQ(name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-"), std::string::npos);
  EXPECT_LE(name.size(), 128u);
  EXPECT_EQ(MachineClass(), name);
}

TEST(MachineClass, ContainsTheSelectedInstructionSet) {
  const std::string target(SimdTarget());
  const std::string least(SimdTargets().back());
  if (least == target) GTEST_SKIP() << "this machine has only " << target;
  const std::string name = MachineClass();
  ASSERT_TRUE(UseSimdTarget(least).ok());
  EXPECT_THAT(MachineClass(), testing::HasSubstr("-" + least + "-"));
  ASSERT_TRUE(UseSimdTarget(target).ok());
  EXPECT_EQ(MachineClass(), name);
}

TEST(ProcessorName, HasOnlyPrintableCharactersAndNoOuterBlanks) {
  const std::string name = ProcessorName();
  ASSERT_FALSE(name.empty());
  for (const char character : name) EXPECT_TRUE(character >= ' ' && character <= '~');
  EXPECT_NE(name.front(), ' ');
  EXPECT_NE(name.back(), ' ');
}

}  // namespace
}  // namespace sweepstake
