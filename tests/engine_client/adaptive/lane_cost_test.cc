#include "engine_client/adaptive/lane_cost.h"

#include <gtest/gtest.h>

#include "tests/support/scripted_clock.h"

namespace sweepstake {
namespace {

using test_support::kMs;

class LaneCostTest : public ::testing::Test {
 protected:
  void Search(uint64_t ns, uint32_t epoch = 0) { cost_.End(cost_.Begin(), ns, epoch); }
  void Searches(int count, uint64_t ns, uint32_t epoch = 0) {
    for (int k = 0; k < count; ++k) Search(ns, epoch);
  }
  // Runs `count` searches alone, then `count` searches during the lane's work. Returns the
  // estimated extra time of the searches during the work.
  double Work(int count, uint64_t alone_ns, uint64_t beside_ns, uint32_t epoch = 0) {
    Searches(count, alone_ns, epoch);
    cost_.BeginWork();
    Searches(count, beside_ns, epoch);
    return cost_.EndWork(static_cast<uint64_t>(count) * beside_ns);
  }

  LaneCost cost_;
};

TEST_F(LaneCostTest, IsThePriorBeforeAnyMeasurement) {
  EXPECT_DOUBLE_EQ(cost_.slowdown(), LaneCost::kPriorSlowdown);
  cost_.BeginWork();
  EXPECT_DOUBLE_EQ(cost_.EndWork(10 * kMs), 1e6);
  Searches(100, kMs);
  cost_.BeginWork();
  EXPECT_DOUBLE_EQ(cost_.EndWork(10 * kMs), 1e6);  // there was no search during the work
  Searches(3, kMs);
  cost_.BeginWork();
  Searches(4, 5 * kMs);
  EXPECT_DOUBLE_EQ(cost_.EndWork(10 * kMs), 1e6);  // there were too few searches before the work
}

TEST_F(LaneCostTest, IsTheExtraTimeOfConcurrentSearches) {
  for (int k = 0; k < 30; ++k) Work(100, kMs, 3 * kMs / 2);
  EXPECT_NEAR(cost_.slowdown(), 0.5, 1e-3);
  const uint64_t before_ns = cost_.total_ns();
  EXPECT_NEAR(Work(100, kMs, 3 * kMs / 2), 75e6, 2e5);
  EXPECT_NEAR(static_cast<double>(cost_.total_ns() - before_ns), 75e6, 2e5);
}

TEST_F(LaneCostTest, FollowsAChangeOfTheSlowdown) {
  for (int k = 0; k < 30; ++k) Work(100, kMs, 2 * kMs);
  for (int k = 0; k < 30; ++k) Work(100, kMs, kMs);
  EXPECT_LT(cost_.slowdown(), 0.05);
}

TEST_F(LaneCostTest, IsZeroIfConcurrentSearchesAreFaster) {
  for (int k = 0; k < 10; ++k) Work(100, kMs, kMs * 9 / 10);
  EXPECT_EQ(cost_.slowdown(), 0);
  EXPECT_EQ(Work(100, kMs, kMs * 9 / 10), 0);
}

TEST_F(LaneCostTest, ComparesOnlySearchesOfTheSameArm) {
  Work(100, kMs, kMs);
  const double before = cost_.slowdown();
  Work(100, kMs, 2 * kMs, /*epoch=*/1);
  EXPECT_DOUBLE_EQ(cost_.slowdown(), before);
  Work(100, kMs, 2 * kMs, /*epoch=*/1);
  EXPECT_GT(cost_.slowdown(), 0.2);
}

TEST_F(LaneCostTest, CountsAPartlyConcurrentSearchAsConcurrent) {
  Searches(100, kMs);
  uint32_t begun = cost_.Begin();
  cost_.BeginWork();
  cost_.End(begun, 2 * kMs, 0);
  begun = cost_.Begin();
  cost_.EndWork(2 * kMs);  // measures the extra time of the first search
  EXPECT_NEAR(cost_.slowdown(), (0.1 * 2 + 0.5) / (2 + 1), 1e-9);
  cost_.End(begun, 9 * kMs, 0);
  Searches(100, kMs);
  cost_.BeginWork();
  Search(kMs);
  cost_.EndWork(kMs);  // the comparison does not use the search of 9 ms
  EXPECT_NEAR(cost_.slowdown(), (0.1 * 2 + 0.45) / (2 + 0.9 + 1), 1e-9);
}

TEST_F(LaneCostTest, HardlyChangesWithOneHitch) {
  Work(1000, kMs, kMs);
  Searches(10, kMs);
  cost_.BeginWork();
  Search(500 * kMs);
  cost_.EndWork(kMs);
  EXPECT_LT(cost_.slowdown(), 0.01);
}

}  // namespace
}  // namespace sweepstake
