#include "server/auth/failure_limit.h"

#include <gtest/gtest.h>

namespace sweepstake::auth {
namespace {

using Level = FailureLimit::Level;

TEST(FailureLimitTest, TheEleventhFailureOfAnAddressWithinAMinuteIsOverTheLimit) {
  FailureLimit limit;
  for (int i = 1; i < 10; ++i) EXPECT_EQ(limit.Count("a", 100 + i), Level::kBelow) << i;
  EXPECT_EQ(limit.Count("a", 200), Level::kReached);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(limit.Count("a", 300), Level::kBeyond);
  EXPECT_EQ(limit.Count("b", 300), Level::kBelow) << "another address";
}

TEST(FailureLimitTest, TheCountRestartsAMinuteAfterTheFirstFailure) {
  FailureLimit limit;
  for (int i = 0; i < 20; ++i) limit.Count("a", 100);
  EXPECT_EQ(limit.Count("a", 99 + FailureLimit::kIntervalNs), Level::kBeyond);
  EXPECT_EQ(limit.Count("a", 100 + FailureLimit::kIntervalNs), Level::kBelow);
}

TEST(FailureLimitTest, MemoryStaysBoundedWithAMillionAddresses) {
  FailureLimit limit;
  for (int i = 0; i < 1'000'000; ++i) limit.Count(std::to_string(i), 100);
  EXPECT_EQ(limit.size(), FailureLimit::kMaxAddresses);
  limit.Count("a", 100 + FailureLimit::kIntervalNs);
  EXPECT_EQ(limit.size(), 1u);
}

}  // namespace
}  // namespace sweepstake::auth
