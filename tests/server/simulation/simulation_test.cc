// Runs simulations (simulation.h). The environment variables TEST_SEEDS and TEST_SEED set the
// number of runs and the first seed: TEST_SEED=7 TEST_SEEDS=1 repeats the run of seed 7.
#include <gtest/gtest.h>

#include <iostream>

#include "tests/server/simulation/simulation.h"
#include "tests/support/size_of_run.h"

namespace sweepstake::simulation {
namespace {

// The seeds are divided into parts, so that they can run in parallel.
constexpr uint64_t kParts = 4;

class SeededSimulationTest : public testing::TestWithParam<uint64_t> {};

TEST_P(SeededSimulationTest, NoAcknowledgedEvidenceIsLostOrCountedTwice) {
  const uint64_t first = test_support::FromEnvironment("TEST_SEED", 1);
  const uint64_t count = test_support::FromEnvironment("TEST_SEEDS", 1000);
  Tally tally;
  for (uint64_t seed = first + GetParam(); seed < first + count; seed += kParts) {
    Simulation simulation(seed);
    for (const std::string& problem : simulation.Run())
      ADD_FAILURE() << "TEST_SEED=" << seed << ": " << problem;
    tally += simulation.tally();
    if (HasFailure()) break;
  }
  std::cout << tally.Text() << "\n";
  if (count >= 1000) {
    EXPECT_EQ(tally.NeverHappened(), "");
  }
}

TEST(SimulationTest, ASeedRepeatsItsRun) {
  const auto run = [] {
    Simulation simulation(7);
    simulation.Run();
    return simulation.tally().Text();
  };
  EXPECT_EQ(run(), run());
}

INSTANTIATE_TEST_SUITE_P(Part, SeededSimulationTest, testing::Range(uint64_t{0}, kParts));

}  // namespace
}  // namespace sweepstake::simulation
