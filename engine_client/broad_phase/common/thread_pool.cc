// The thread pool of executor.h. A job is one call of RunParts. One atomic word holds the number of
// the job and its unclaimed parts.
#include <atomic>
#include <cassert>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "engine_client/broad_phase/host/hook_points.h"
#include "engine_client/broad_phase/host/thread_owned.h"
#include "sweepstake/executor.h"

#if defined(__x86_64__) || defined(_M_X64)
#include <immintrin.h>
#endif

namespace sweepstake {
namespace {

// The number of pause instructions before a thread sleeps. A thread spins long enough to see the
// next parallel loop of the same frame. Waking it from sleep would take a large part of the frame.
constexpr int kSpinsBeforeSleep = 6000;

void Pause() {
#if defined(__x86_64__) || defined(_M_X64)
  _mm_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

class ThreadPool final : public Executor {
 public:
  ThreadPool() = default;
  // Starts the workers outside of the constructor. If the system fails to create a thread, the
  // destructor can then still join the others.
  void Start(size_t thread_count) {
    workers_->threads.reserve(thread_count - 1);
    for (size_t i = 1; i < thread_count; ++i) {
      workers_->threads.emplace_back([this] { Work(); });
    }
  }
  ~ThreadPool() override {
    if (workers_.get_deleter().is_in_child()) return;
    stopping_.store(true);
    Publish(0);
    for (std::thread& worker : workers_->threads) worker.join();
  }

  size_t thread_count() const noexcept override { return workers_->threads.size() + 1; }

  void RunParts(size_t part_count, RunPart run_part, void* context) noexcept override {
    assert(part_count <= kLast);
    if (part_count == 0) return;
    run_part_ = run_part;
    context_ = context;
    done_.store(0, std::memory_order_relaxed);
    Publish(part_count);
    while (RunOne(End::kFront)) {
    }
    for (int spins = 0; done_.load(std::memory_order_acquire) != part_count; ++spins) {
      // Gives up the core after kSpinsBeforeSleep rounds: the thread that runs the last part may
      // need it.
      spins < kSpinsBeforeSleep ? Pause() : std::this_thread::yield();
    }
  }

 private:
  // The fields of job_, from the highest bits: the number of the job (32 bits), the first unclaimed
  // part and the end of the unclaimed parts (16 bits each).
  static constexpr uint64_t kLast = 0xFFFF;
  static constexpr uint64_t First(uint64_t job) { return job >> 16 & kLast; }
  static constexpr uint64_t Behind(uint64_t job) { return job & kLast; }
  static constexpr bool HasUnclaimed(uint64_t job) { return First(job) < Behind(job); }

  // The caller claims parts from the front, the workers from the back. A thread then gets mostly
  // the same parts in each loop, and their data is still in its cache.
  enum class End { kFront, kBack };

  void Publish(uint64_t part_count) noexcept {
    const uint64_t number = (job_.load(std::memory_order_relaxed) >> 32) + 1;
    job_.store(number << 32 | part_count);
    if (sleeper_count_.load() == 0) return;
    // Taking the lock here waits for a thread in Sleep that has checked for a job but does not wait
    // yet. Such a thread would miss the notification.
    { const std::scoped_lock lock(workers_->mutex); }
    workers_->wake.notify_all();
  }

  // Waits until there is a job. No wake-up is lost: either the sleeping thread sees the job, or
  // Publish sees that a thread sleeps. std::atomic::wait is not used: where libstdc++ has no futex,
  // as on Windows, it loses wake-ups.
  void Sleep() noexcept {
    std::unique_lock lock(workers_->mutex);
    sleeper_count_.fetch_add(1);
    workers_->wake.wait(lock, [&] { return HasUnclaimed(job_.load()) || stopping_.load(); });
    sleeper_count_.fetch_sub(1, std::memory_order_relaxed);
  }

  // Claims a part and runs it. Returns false if no part is left. Reads run_part_ and context_ only
  // after it has claimed a part: they do not change until that part is done.
  bool RunOne(End end) noexcept {
    const uint64_t step = end == End::kFront ? kLast + 1 : uint64_t{0} - 1;
    uint64_t job = job_.load(std::memory_order_acquire);
    do {
      if (!HasUnclaimed(job)) return false;
    } while (!job_.compare_exchange_weak(job, job + step, std::memory_order_acquire));
    run_part_(context_, end == End::kFront ? First(job) : Behind(job) - 1);
    done_.fetch_add(1, std::memory_order_release);
    return true;
  }

  void Work() noexcept {
    NoteThreadStarted("swp pool");
    while (!stopping_.load(std::memory_order_relaxed)) {
      if (!SpinForJob()) Sleep();
      while (RunOne(End::kBack)) {
      }
    }
  }

  bool SpinForJob() const noexcept {
    for (int spin = 0; spin < kSpinsBeforeSleep; ++spin) {
      if (HasUnclaimed(job_.load(std::memory_order_relaxed))) return true;
      Pause();
    }
    return false;
  }

  struct Workers {
    std::mutex mutex;
    std::condition_variable wake;
    std::vector<std::thread> threads;
  };

  // job_ and done_ have separate cache lines, so that threads that wait for job_ do not slow down
  // threads that increment done_.
  alignas(64) std::atomic<uint64_t> job_{0};
  alignas(64) std::atomic<size_t> done_{0};
  alignas(64) RunPart run_part_ = nullptr;
  void* context_ = nullptr;
  std::atomic<size_t> sleeper_count_{0};
  std::atomic<bool> stopping_{false};
  const ThreadOwned<Workers> workers_ = MakeThreadOwned<Workers>();
};

}  // namespace

std::unique_ptr<Executor> MakeThreadPool(size_t thread_count) {
  assert(thread_count >= 1 && thread_count <= 256);
  auto pool = std::make_unique<ThreadPool>();
  pool->Start(thread_count);
  return pool;
}

}  // namespace sweepstake
