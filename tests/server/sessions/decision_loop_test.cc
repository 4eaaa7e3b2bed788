// Tests the decision loop: the lateness of its timers, and the thread that runs it.
#include "server/sessions/common/decision_loop.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>
#include <vector>

#include "tests/server/sessions/manual_clock.h"

namespace sweepstake::sessions {
namespace {

using std::chrono::nanoseconds;
using ::testing::ElementsAre;

TEST(DecisionLoopTest, TheLatenessOfATimerIncludesTheTimersBeforeIt) {
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

TEST(DecisionLoopTest, TheCallerRunsPostedAndDueTasksAndTheTasksThatTheyPost) {
  ManualClock clock;
  const int64_t start_ns = clock.NowNs();
  std::vector<int> order;
  DecisionLoop loop(clock, {}, DecisionLoop::Runner::kCaller);
  loop.PostAt(start_ns + 100, [&] { order.push_back(3); });
  loop.Post([&] {
    order.push_back(1);
    loop.Post([&] { order.push_back(2); });
  });
  EXPECT_EQ(loop.RunReady(), start_ns + 100);
  EXPECT_THAT(order, ElementsAre(1, 2));
  clock.Advance(100);
  EXPECT_EQ(loop.RunReady(), LoopClock::kNever);
  EXPECT_THAT(order, ElementsAre(1, 2, 3));
}

TEST(DecisionLoopTest, PostedTasksOvertakeManyLaterTasksAndTimers) {
  ManualClock clock;
  DecisionLoop loop(clock, {}, DecisionLoop::Runner::kCaller);
  int done_before = 0;
  int done = 0;
  loop.PostLater([&] { loop.Post([&] { done_before = done; }); });
  for (int i = 0; i < 1000; ++i) {
    loop.PostLater([&] { ++done; });
    loop.PostAt(clock.NowNs(), [&] { ++done; });
  }
  EXPECT_EQ(loop.RunReady(), LoopClock::kNever);
  EXPECT_EQ(done, 2000);
  EXPECT_LT(done_before, 20);
}

}  // namespace
}  // namespace sweepstake::sessions
