// Runs independent pieces of work on several threads.
#pragma once

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace sweepstake::cli {

// Runs work(0) … work(count − 1) in any order on `thread_count` threads (0 counts as 1) and returns
// when all are done. `on_done` is called on the calling thread with the number of pieces done.
inline void RunParallel(uint64_t count, uint32_t thread_count,
                        const std::function<void(uint64_t)>& work,
                        const std::function<void(uint64_t done)>& on_done) {
  std::atomic<uint64_t> next = 0;
  std::mutex mutex;
  std::condition_variable changed;
  uint64_t done = 0;
  const auto take = [&] {
    for (uint64_t i = next++; i < count; i = next++) {
      work(i);
      const std::lock_guard lock(mutex);
      ++done;
      changed.notify_one();
    }
  };
  std::vector<std::thread> threads;
  for (uint32_t i = 0; i < std::max(thread_count, 1U); ++i) threads.emplace_back(take);
  std::unique_lock lock(mutex);
  while (done < count) {
    changed.wait(lock);
    const uint64_t seen = done;
    lock.unlock();
    on_done(seen);
    lock.lock();
  }
  lock.unlock();
  on_done(count);
  for (std::thread& thread : threads) thread.join();
}

}  // namespace sweepstake::cli
