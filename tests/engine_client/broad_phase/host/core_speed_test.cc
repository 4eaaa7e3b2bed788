#include "engine_client/broad_phase/host/core_speed.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#if defined(__linux__)
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "tests/support/temporary_directory.h"
#endif

namespace sweepstake {
namespace {

TEST(CoreSpeed, IsAShareBetweenZeroAndOne) {
  EXPECT_GT(CoreSpeed(), 0);
  EXPECT_LE(CoreSpeed(), 1);
}

#if defined(__linux__)

using ::testing::Each;
using ::testing::ElementsAre;

class CoreSpeeds : public ::testing::Test {
 protected:
  void Rate(size_t core, const std::string& name, const std::string& rating) {
    const std::filesystem::path file = folder_.path() / ("cpu" + std::to_string(core)) / name;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file) << rating << '\n';
  }
  std::vector<double> Read(size_t core_count) const {
    std::vector<double> speeds(core_count);
    ReadCoreSpeeds(folder_.path().string().c_str(), speeds);
    return speeds;
  }

  test_support::TemporaryDirectory folder_;
};

TEST_F(CoreSpeeds, AreEqualIfTheSystemReportsNone) {
  EXPECT_THAT(Read(4), Each(1.0));
  EXPECT_THAT(Read(0), ElementsAre());
}

TEST_F(CoreSpeeds, AreProportionalToTheCapacities) {
  const char* const ratings[] = {"256", "256", "768", "1024"};
  for (size_t core = 0; core < 4; ++core) Rate(core, "cpu_capacity", ratings[core]);
  Rate(0, "acpi_cppc/highest_perf", "1");
  EXPECT_THAT(Read(4), ElementsAre(0.25, 0.25, 0.75, 1.0));
}

TEST_F(CoreSpeeds, AreProportionalToAcpiRatingsWithoutCapacities) {
  Rate(0, "acpi_cppc/highest_perf", "64");
  Rate(1, "acpi_cppc/highest_perf", "32");
  EXPECT_THAT(Read(2), ElementsAre(1.0, 0.5));
}

TEST_F(CoreSpeeds, AreEqualIfAcpiRatingsDifferOnlyLittle) {
  Rate(0, "acpi_cppc/highest_perf", "236");
  Rate(1, "acpi_cppc/highest_perf", "166");
  EXPECT_THAT(Read(2), Each(1.0));
}

TEST_F(CoreSpeeds, AreTheMaximumForCoresWithoutARating) {
  for (const std::string wrong : {"", "fast", "0", "-5"}) {
    Rate(0, "cpu_capacity", "512");
    Rate(1, "cpu_capacity", wrong);
    Rate(3, "cpu_capacity", "1024");
    EXPECT_THAT(Read(4), ElementsAre(0.5, 1.0, 1.0, 1.0)) << wrong;
  }
}

#endif

}  // namespace
}  // namespace sweepstake
