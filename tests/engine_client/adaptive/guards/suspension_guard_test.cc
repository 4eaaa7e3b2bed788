#include "engine_client/adaptive/guards/suspension_guard.h"

#include <gtest/gtest.h>

#include "tests/support/scripted_clock.h"

namespace sweepstake {
namespace {

using test_support::kMs;
using test_support::ScriptedClock;

constexpr uint64_t kSecond = 1000 * kMs;

// Counts the readings of CPU times.
class CountingClock final : public Clock {
 public:
  uint64_t NowNs() noexcept override { return clock.NowNs(); }
  uint64_t ThreadCpuNs() noexcept override {
    ++cpu_reading_count;
    return clock.ThreadCpuNs();
  }
  uint64_t ProcessCpuNs() noexcept override {
    ++cpu_reading_count;
    return clock.ProcessCpuNs();
  }

  ScriptedClock clock;
  uint64_t cpu_reading_count = 0;
};

class SuspensionGuardTest : public ::testing::Test {
 protected:
  SuspensionGuardTest() { clock_.clock.ReportCpu(); }

  // Runs a search that computes, waits for other threads that compute, and is stopped.
  bool Search(SuspensionGuard& guard, uint64_t computed_ns, uint64_t stopped_ns,
              uint64_t computed_elsewhere_ns = 0) {
    const uint64_t begin_ns = guard.BeginSearch();
    clock_.clock.Advance(computed_ns);
    clock_.clock.AdvanceWaiting(computed_elsewhere_ns, computed_elsewhere_ns);
    clock_.clock.AdvanceWaiting(stopped_ns);
    return guard.EndSearch(begin_ns, clock_.NowNs() - begin_ns);
  }
  // Runs a frame with a short search and a wait of `idle_ns`. Returns whether it was suspended.
  bool Frame(SuspensionGuard& guard, uint64_t idle_ns, uint32_t flags = 0) {
    const uint64_t begin_ns = clock_.NowNs();
    Search(guard, kMs, 0);
    clock_.clock.AdvanceWaiting(idle_ns);
    return guard.EndFrame({.frame_time_ns = clock_.NowNs() - begin_ns, .flags = flags});
  }

  CountingClock clock_;
};

TEST_F(SuspensionGuardTest, FindsAStopOfTheProcessInASearch) {
  SuspensionGuard guard(clock_, false);
  EXPECT_TRUE(Search(guard, 5 * kMs, 6 * kSecond));
  EXPECT_TRUE(guard.EndFrame({.frame_time_ns = 6 * kSecond}));
  EXPECT_FALSE(Search(guard, 5 * kMs, 0));
  EXPECT_FALSE(guard.EndFrame({.frame_time_ns = 10 * kMs}));
}

TEST_F(SuspensionGuardTest, NeverExcusesAnArmThatComputesForLong) {
  SuspensionGuard guard(clock_, false);
  EXPECT_FALSE(Search(guard, 6 * kSecond, 0));
  EXPECT_FALSE(Search(guard, kSecond, 6 * kSecond)) << "an arm of a second is slow in any case";
  EXPECT_FALSE(guard.EndFrame({.frame_time_ns = 13 * kSecond}));
}

// With n busy threads per core, a thread computes for 1/n of the time.
TEST_F(SuspensionGuardTest, NeverExcusesABusyMachineUpToTheShare) {
  SuspensionGuard guard(clock_, false);
  for (uint64_t threads = 2; threads <= SuspensionGuard::kComputedShare; ++threads) {
    EXPECT_FALSE(Search(guard, kSecond, (threads - 1) * kSecond)) << threads;
  }
}

TEST_F(SuspensionGuardTest, ExaminesOnlyLongSearches) {
  SuspensionGuard guard(clock_, false);
  EXPECT_FALSE(Search(guard, 0, SuspensionGuard::kSuspiciousSearchNs - 1));
  EXPECT_TRUE(Search(guard, 0, SuspensionGuard::kSuspiciousSearchNs));
}

// The frame thread waits while other threads run the parts of its search.
TEST_F(SuspensionGuardTest, CountsTheWorkOfOtherThreadsOnlyInParallelSearches) {
  SuspensionGuard parallel(clock_, true);
  EXPECT_FALSE(Search(parallel, kMs, 0, 6 * kSecond));
  EXPECT_TRUE(Search(parallel, kMs, 6 * kSecond, 5 * kMs));
  SuspensionGuard serial(clock_, false);
  EXPECT_TRUE(Search(serial, kMs, 0, 6 * kSecond));
}

TEST_F(SuspensionGuardTest, FindsAStopBetweenTheSearches) {
  SuspensionGuard guard(clock_, false);
  EXPECT_FALSE(Frame(guard, 16 * kMs));
  EXPECT_TRUE(Frame(guard, 2 * kSecond)) << "after the search";
  EXPECT_FALSE(Frame(guard, 16 * kMs));
  clock_.clock.AdvanceWaiting(2 * kSecond);
  Search(guard, kMs, 0);
  EXPECT_TRUE(guard.EndFrame({.frame_time_ns = 2 * kSecond + kMs})) << "before the search";
  EXPECT_FALSE(Frame(guard, 2 * kSecond, kFramePaused));
  EXPECT_FALSE(Frame(guard, 2 * kSecond, kFrameLoading));
  EXPECT_FALSE(Frame(guard, SuspensionGuard::kSuspiciousFrameNs - 2 * kMs));
}

TEST_F(SuspensionGuardTest, AWaitForThreadsThatWorkIsNoStop) {
  SuspensionGuard guard(clock_, false);
  Frame(guard, 0);
  clock_.clock.AdvanceWaiting(2 * kSecond, kSecond);
  EXPECT_FALSE(guard.EndFrame({.frame_time_ns = 2 * kSecond + kMs}));
}

// An engine may report a frame time that did not pass on the clock.
TEST_F(SuspensionGuardTest, AFrameTimeThatDidNotPassIsNoStop) {
  SuspensionGuard guard(clock_, false);
  Frame(guard, 0);
  EXPECT_FALSE(guard.EndFrame({.frame_time_ns = 6 * kSecond}));
}

TEST_F(SuspensionGuardTest, ALongSeriesIsNoSuspension) {
  SuspensionGuard guard(clock_, false);
  Frame(guard, 0);
  for (uint32_t frame = 0; frame < 3 * SuspensionGuard::kMaxInARow; ++frame) {
    EXPECT_EQ(Frame(guard, 2 * kSecond), frame < SuspensionGuard::kMaxInARow) << frame;
  }
  EXPECT_FALSE(Frame(guard, 0));
  EXPECT_TRUE(Frame(guard, 2 * kSecond)) << "a calm frame ends the series";
}

TEST_F(SuspensionGuardTest, FindsNothingIfCpuTimesAreUnknown) {
  ScriptedClock clock;
  SuspensionGuard guard(clock, false);
  const uint64_t begin_ns = guard.BeginSearch();
  clock.AdvanceWaiting(6 * kSecond);
  EXPECT_FALSE(guard.EndSearch(begin_ns, 6 * kSecond));
  EXPECT_FALSE(guard.EndFrame({.frame_time_ns = 6 * kSecond}));
}

TEST_F(SuspensionGuardTest, ReadsCpuTimesTwentyTimesASecondAndAfterALongSearch) {
  SuspensionGuard guard(clock_, false);
  for (int frame = 0; frame < 100; ++frame) Frame(guard, 9 * kMs);  // one second
  EXPECT_EQ(clock_.cpu_reading_count, 2U * 20U);
  Search(guard, 6 * kSecond, 0);
  EXPECT_EQ(clock_.cpu_reading_count, 2U * 22U);
}

// The search begins after the CPU times are read, so that its time does not include the reading.
TEST_F(SuspensionGuardTest, ReadingCpuTimesIsNotPartOfTheSearch) {
  clock_.clock.SetReading(1);
  SuspensionGuard guard(clock_, false);
  EXPECT_EQ(guard.BeginSearch(), 2U);
  EXPECT_EQ(guard.BeginSearch(), 3U);
}

}  // namespace
}  // namespace sweepstake
