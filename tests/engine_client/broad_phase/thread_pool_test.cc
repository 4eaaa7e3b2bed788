#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <fstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#if defined(__linux__)
#include <unistd.h>
#endif

#include "engine_client/broad_phase/common/parallel.h"
#include "gtest/gtest.h"
#include "sweepstake/executor.h"
#include "tests/support/child_process.h"

namespace sweepstake {
namespace {

TEST(ThreadPoolTest, RunsEveryPartOnce) {
  for (const size_t threads : {1, 2, 5}) {
    const auto pool = MakeThreadPool(threads);
    EXPECT_EQ(pool->thread_count(), threads);
    for (size_t part_count = 0; part_count < 200; ++part_count) {
      std::vector<int> runs(part_count);
      RunParts(pool.get(), part_count, [&](size_t part) { ++runs[part]; });
      EXPECT_EQ(std::count(runs.begin(), runs.end(), 1), static_cast<ptrdiff_t>(part_count));
    }
  }
}

TEST(ThreadPoolTest, WakesSleepingThreads) {
  const auto pool = MakeThreadPool(3);
  for (int round = 0; round < 20; ++round) {
    // Three parts wait for one another, so that only three concurrent threads can finish them.
    std::atomic<int> begun{0};
    RunParts(pool.get(), 3, [&](size_t) {
      begun.fetch_add(1);
      while (begun.load() < 3) std::this_thread::yield();
    });
    EXPECT_EQ(begun.load(), 3);
    if (round % 5 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

TEST(ThreadPoolTest, CanBeDestroyedWhileItsThreadsGoToSleep) {
  for (int round = 0; round < 300; ++round) {
    const auto pool = MakeThreadPool(3);
    std::atomic<int> ended{0};
    RunParts(pool.get(), 3, [&](size_t) { ended.fetch_add(1); });
    // The pauses range from the time in which threads begin to look for work to the time after
    // which all sleep.
    for (int spins = round * 100; spins > 0; --spins) ended.load();
    EXPECT_EQ(ended.load(), 3);
  }
}

TEST(RunPartsTest, ThrowsIfAPartRunsOutOfMemoryAndRunsTheOthers) {
  const auto pool = MakeThreadPool(2);
  std::atomic<int> ended{0};
  EXPECT_THROW(RunParts(pool.get(), 8,
                        [&](size_t part) {
                          if (part == 3) throw std::bad_alloc();
                          ended.fetch_add(1);
                        }),
               std::bad_alloc);
  EXPECT_EQ(ended.load(), 7);
}

TEST(RunPartsTest, RethrowsAnyExceptionOfAPart) {
  const auto pool = MakeThreadPool(2);
  EXPECT_THROW(RunParts(pool.get(), 4, [](size_t) { throw std::length_error("too long"); }),
               std::length_error);
}

TEST(RangeOfPartTest, CoversAllItemsInGranules) {
  for (const size_t items : {0, 1, 15, 16, 17, 1000}) {
    for (const size_t parts : {1, 2, 3, 8}) {
      size_t next = 0;
      for (size_t part = 0; part < parts; ++part) {
        const PartRange range = RangeOfPart(items, part, parts, 16);
        EXPECT_EQ(range.begin, next);
        EXPECT_TRUE(range.begin % 16 == 0 || range.begin == items);
        next = range.end;
      }
      EXPECT_EQ(next, items);
    }
  }
}

TEST(PairPartsTest, JoinsThePairsOfThePartsInOrder) {
  const auto pool = MakeThreadPool(2);
  PairParts parts;
  for (const uint32_t count : {10U, 4000U, 100'000U}) {
    PairBuffer pairs;
    pairs.Append({0, 0});
    const uint64_t checks =
        parts.Run(pool.get(), count, 100, 1, pairs, [](size_t begin, size_t end, PairBuffer& out) {
          for (size_t i = begin; i < end; ++i) out.Append({0, static_cast<uint32_t>(i + 1)});
          return uint64_t{end - begin};
        });
    EXPECT_EQ(checks, count);
    ASSERT_EQ(pairs.size(), count + 1);
    for (uint32_t i = 0; i <= count; ++i) EXPECT_EQ(pairs.pairs()[i].b, i);
  }
}

TEST(PairPartsTest, StartsNoPartAfterAStop) {
  class Stop final : public StopRequest {
   public:
    bool WantsStop(uint64_t, uint64_t) noexcept override { return is_wanted; }
    std::atomic<bool> is_wanted{false};
  } stop;
  const auto pool = MakeThreadPool(2);
  PairParts parts;
  PairBuffer pairs;
  std::atomic<int> begun{0};
  const auto find = [&](size_t, size_t, PairBuffer& out) {
    out.Append({0, 1});
    stop.is_wanted = true;
    ++begun;
    return uint64_t{1};
  };
  const uint64_t checks = parts.Run(pool.get(), 100'000, 100, 1, pairs, find, &stop);
  EXPECT_LE(begun, 2) << "at most one part on each thread";
  EXPECT_EQ(checks, static_cast<uint64_t>(begun));
  EXPECT_LE(pairs.size(), 1U) << "only pairs of other parts remain";
}

#if defined(__linux__) && SWEEPSTAKE_CAN_FORK
// Returns the state of a thread of this process, as in the manual page proc(5).
char StateOfThread(pid_t thread) {
  std::ifstream file("/proc/self/task/" + std::to_string(thread) + "/stat");
  std::string line;
  std::getline(file, line);
  const size_t name_end = line.rfind(')');  // the state follows the name and a space
  return name_end + 2 < line.size() ? line[name_end + 2] : '?';
}

// The child has none of the pool's threads, which sleep in the parent.
TEST(ThreadPoolTest, AForkedChildDestroysThePoolWithoutWaiting) {
  auto pool = MakeThreadPool(2);
  // Two parts wait for one another, so that the other thread has started.
  std::atomic<int> begun{0};
  std::atomic<pid_t> worker{0};
  const pid_t caller = gettid();
  RunParts(pool.get(), 2, [&](size_t) {
    if (gettid() != caller) worker = gettid();
    begun.fetch_add(1);
    while (begun.load() < 2) std::this_thread::yield();
  });
  ASSERT_NE(worker, 0);
  // From here on, the thread blocks only where it waits for the next job.
  while (StateOfThread(worker) != 'S') std::this_thread::yield();
  EXPECT_EQ(test_support::StatusOfChild([&] { pool.reset(); }), 0);
}
#endif

}  // namespace
}  // namespace sweepstake
