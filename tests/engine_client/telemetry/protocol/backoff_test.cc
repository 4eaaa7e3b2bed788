#include "engine_client/telemetry/protocol/backoff.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace sweepstake {
namespace {

TEST(Backoff, StaysWithinABoundThatDoublesUpToTheMaximum) {
  for (uint64_t seed = 0; seed < 200; ++seed) {
    Backoff backoff(100, 1000, seed);
    for (const uint32_t bound : {100U, 200U, 400U, 800U, 1000U, 1000U}) {
      EXPECT_LE(backoff.NextMs(), bound);
    }
  }
}

TEST(Backoff, DelaysAreUniformUpToTheBound) {
  uint64_t sum = 0;
  uint32_t min = 1000;
  uint32_t max = 0;
  for (uint64_t seed = 0; seed < 1000; ++seed) {
    const uint32_t delay = Backoff(100, 1000, seed).NextMs();
    sum += delay;
    min = std::min(min, delay);
    max = std::max(max, delay);
  }
  EXPECT_NEAR(static_cast<double>(sum) / 1000, 50, 5);
  EXPECT_LT(min, 3U);
  EXPECT_GT(max, 97U);
}

TEST(Backoff, GivesTheSameDelaysForTheSameSeed) {
  Backoff first(100, 10'000, 7);
  Backoff second(100, 10'000, 7);
  for (int i = 0; i < 20; ++i) EXPECT_EQ(first.NextMs(), second.NextMs());
}

TEST(Backoff, StartsAtTheMinimumAfterAReset) {
  Backoff backoff(1, 1'000'000, 3);
  for (int i = 0; i < 30; ++i) backoff.NextMs();
  backoff.Reset();
  EXPECT_LE(backoff.NextMs(), 1U);
}

TEST(Backoff, ALongDelayIsAtLeastHalfOfTheMaximum) {
  Backoff backoff(100, 10'000, 5);
  for (int i = 0; i < 100; ++i) {
    const uint32_t delay = backoff.LongMs();
    EXPECT_GE(delay, 5000U);
    EXPECT_LE(delay, 10'000U);
  }
}

}  // namespace
}  // namespace sweepstake
