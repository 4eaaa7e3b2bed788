// The decision loop: how late its timers run.
#include "server/rpc/common/decision_loop.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>
#include <vector>

#include "tests/server/rpc/manual_clock.h"

namespace sweepstake::rpc {
namespace {

using std::chrono::nanoseconds;
using ::testing::ElementsAre;

TEST(DecisionLoopTest, ATimersLatenessIncludesTheTimersBeforeIt) {
  ManualClock clock;
  const int64_t start_ns = clock.NowNs();
  std::vector<nanoseconds> lateness;
  std::promise<void> done;
  DecisionLoop loop(clock, [&](nanoseconds late) { lateness.push_back(late); });
  loop.PostAt(start_ns + 100, [&] { clock.Advance(20); });
  loop.PostAt(start_ns + 110, [&] { done.set_value(); });
  clock.Advance(130);
  done.get_future().wait();
  EXPECT_THAT(lateness, ElementsAre(nanoseconds(30), nanoseconds(40)));
}

}  // namespace
}  // namespace sweepstake::rpc
