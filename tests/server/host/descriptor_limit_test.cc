// Tests the limit of open files.
#include "server/host/descriptor_limit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

namespace sweepstake::server {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(DescriptorLimitTest, TheSoftLimitIsRaisedToTheHardLimit) {
  rlimit before{};
  getrlimit(RLIMIT_NOFILE, &before);
  const rlimit low{.rlim_cur = before.rlim_max / 2, .rlim_max = before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &low), 0);
  EXPECT_EQ(RaiseDescriptorLimit(), before.rlim_max);
  rlimit after{};
  getrlimit(RLIMIT_NOFILE, &after);
  EXPECT_EQ(after.rlim_cur, before.rlim_max);
  setrlimit(RLIMIT_NOFILE, &before);
}

TEST(DescriptorLimitTest, ALimitTooLowForTheSessionsGivesAWarning) {
  rpc::RpcOptions options;
  options.max_sessions = 20'000;
  options.max_watchers = 256;
  EXPECT_EQ(DescriptorShortage(131'072, options), std::nullopt);
  EXPECT_EQ(DescriptorShortage(66'072, options), std::nullopt);
  EXPECT_THAT(DescriptorShortage(66'071, options).value(),
              AllOf(HasSubstr("is 66071"), HasSubstr("may need 66072"), HasSubstr("LimitNOFILE"),
                    HasSubstr("--max-sessions")));
}

}  // namespace
}  // namespace sweepstake::server
