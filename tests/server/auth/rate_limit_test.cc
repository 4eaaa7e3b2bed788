#include "server/auth/rate_limit.h"

#include <gtest/gtest.h>

namespace sweepstake::auth {
namespace {

constexpr int64_t kSecondNs = 1'000'000'000;

TEST(RateBucketTest, AllowsABurstOfTenSecondsAndThenTheRate) {
  RateBucket bucket;
  int64_t now_ns = 5 * kSecondNs;
  for (int i = 0; i < 200; ++i) EXPECT_TRUE(bucket.Take(20, now_ns)) << i;
  EXPECT_FALSE(bucket.Take(20, now_ns));
  EXPECT_FALSE(bucket.full(now_ns));
  for (int second = 0; second < 100; ++second) {
    now_ns += kSecondNs;
    for (int i = 0; i < 20; ++i) EXPECT_TRUE(bucket.Take(20, now_ns));
    EXPECT_FALSE(bucket.Take(20, now_ns)) << "refused events are not counted";
  }
  EXPECT_TRUE(bucket.full(now_ns + RateBucket::kBurstNs));
}

TEST(RateLimitTest, EachNameHasItsOwnBucket) {
  RateLimit limit;
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(limit.Take("a", 1, 0));
  EXPECT_FALSE(limit.Take("a", 1, 0));
  EXPECT_TRUE(limit.Take("b", 1, 0));
  EXPECT_TRUE(limit.Take("a", 1, kSecondNs));
}

TEST(RateLimitTest, MemoryStaysBoundedWithAMillionNames) {
  RateLimit limit;
  for (int i = 0; i < 10; ++i) limit.Take("busy", 1, 0);
  for (int i = 0; i < 1'000'000; ++i) {
    limit.Take(std::to_string(i), 1, 0);
    if (i % 1'000 != 0) continue;
    EXPECT_FALSE(limit.Take("busy", 1, 0)) << "a bucket in use is kept";
  }
  EXPECT_EQ(limit.size(), RateLimit::kMaxBuckets);
  limit.Take("late", 1, 100 * kSecondNs);
  EXPECT_EQ(limit.size(), 1u) << "a full bucket is removed";
}

}  // namespace
}  // namespace sweepstake::auth
