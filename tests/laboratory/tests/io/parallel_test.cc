#include "tests/laboratory/io/parallel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

namespace sweepstake::cli {
namespace {

TEST(RunParallel, RunsEachPieceOnceWithAnyNumberOfThreads) {
  for (const uint32_t thread_count : {0U, 1U, 2U, 7U, 100U}) {
    std::vector<std::atomic<int>> runs(50);
    RunParallel(
        runs.size(), thread_count, [&](uint64_t i) { ++runs[i]; }, [](uint64_t) {});
    EXPECT_TRUE(std::all_of(runs.begin(), runs.end(), [](const auto& count) { return count == 1; }))
        << thread_count << " threads";
  }
}

TEST(RunParallel, ReportsFromTheCallingThreadAndEndsWithTheCount) {
  const std::thread::id caller = std::this_thread::get_id();
  std::vector<uint64_t> reported;
  RunParallel(
      20, 3, [](uint64_t) {},
      [&](uint64_t done) {
        EXPECT_EQ(std::this_thread::get_id(), caller);
        reported.push_back(done);
      });
  ASSERT_FALSE(reported.empty());
  EXPECT_TRUE(std::is_sorted(reported.begin(), reported.end()));
  EXPECT_EQ(reported.back(), 20U);
}

TEST(RunParallel, HasAllResultsWhenItReturns) {
  std::vector<uint64_t> squares(200);
  RunParallel(
      squares.size(), 4, [&](uint64_t i) { squares[i] = i * i; }, [](uint64_t) {});
  for (uint64_t i = 0; i < squares.size(); ++i) EXPECT_EQ(squares[i], i * i);
}

TEST(RunParallel, OfNothingReportsZero) {
  uint64_t reported = 99;
  RunParallel(
      0, 2, [](uint64_t) { FAIL(); }, [&](uint64_t done) { reported = done; });
  EXPECT_EQ(reported, 0U);
}

}  // namespace
}  // namespace sweepstake::cli
