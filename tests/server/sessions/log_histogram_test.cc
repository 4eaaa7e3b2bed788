#include "server/sessions/common/log_histogram.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace sweepstake::sessions {
namespace {

uint64_t CountOf(const LogHistogram& histogram) {
  uint64_t count = 0;
  for (const auto& bucket : histogram.buckets()) count += bucket.count;
  return count;
}

// Returns the middle of the bucket that contains the value of this rank, from 1.
double ValueAt(const LogHistogram& histogram, uint64_t rank) {
  for (const auto& bucket : histogram.buckets()) {
    if (rank <= bucket.count) return std::exp2((bucket.number - 0.5) / 8);
    rank -= bucket.count;
  }
  ADD_FAILURE() << "there are fewer values";
  return 0;
}

TEST(LogHistogram, HasEightBucketsInAnOctave) {
  EXPECT_EQ(LogHistogram::BucketOf(0), 0U);
  EXPECT_EQ(LogHistogram::BucketOf(1), 1U);
  EXPECT_EQ(LogHistogram::BucketOf(2), 9U);
  EXPECT_EQ(LogHistogram::BucketOf(1'000'000), LogHistogram::BucketOf(2'000'000) - 8);
  EXPECT_EQ(LogHistogram::BucketOf(UINT64_MAX), 512U);
}

TEST(LogHistogram, ABucketBeginsAtItsLowerBound) {
  for (uint32_t number = 100; number <= 400; ++number) {
    const auto first = static_cast<uint64_t>(std::ceil(std::exp2((number - 1) / 8.0L)));
    EXPECT_EQ(LogHistogram::BucketOf(first), number);
    EXPECT_EQ(LogHistogram::BucketOf(first - 1), number - 1);
  }
}

TEST(LogHistogram, PercentilesAreWithin5PercentOfTheExactOnes) {
  std::mt19937_64 random(20);
  std::vector<uint64_t> values;
  LogHistogram histogram;
  for (int i = 0; i < 1000; ++i) {
    values.push_back(500'000 + (random() >> (40 + random() % 12)));
    histogram.Add(values.back());
  }
  std::sort(values.begin(), values.end());
  EXPECT_EQ(CountOf(histogram), 1000U);
  for (const size_t rank : {1, 500, 950, 990, 1000}) {
    const auto exact = static_cast<double>(values[rank - 1]);
    EXPECT_NEAR(ValueAt(histogram, rank), exact, 0.045 * exact) << rank;
  }
}

TEST(LogHistogram, TheSmallestValuesShareABucketIfThereAreTooManyBuckets) {
  std::vector<uint64_t> values(512);
  for (size_t i = 0; i < values.size(); ++i) {
    values[i] = static_cast<uint64_t>(std::exp2((static_cast<long double>(i) + 0.5L) / 8));
  }
  std::shuffle(values.begin(), values.end(), std::mt19937_64(7));
  LogHistogram histogram;
  for (const uint64_t value : values) histogram.Add(value);
  ASSERT_EQ(histogram.buckets().size(), LogHistogram::kMaxBuckets);
  EXPECT_EQ(CountOf(histogram), 512U);
  for (size_t i = 0; i < LogHistogram::kMaxBuckets; ++i) {
    EXPECT_EQ(histogram.buckets()[i].number, 449 + i);
    EXPECT_EQ(histogram.buckets()[i].count, i == 0 ? 449U : 1U);
  }
  histogram.Clear();
  EXPECT_TRUE(histogram.empty());
}

}  // namespace
}  // namespace sweepstake::sessions
