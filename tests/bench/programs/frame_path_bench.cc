// Measures the cost of adaptation and telemetry on the frame thread without the backend: the frame
// path with a backend that does nothing. Its samples are discarded, or go into a queue that is
// never read, or into a queue that a thread empties as a session does.
//
// Prints nanoseconds per frame (goal: below 100). Counted separately per frame: calls of operator
// new and malloc, calls that could block the thread (see wait_counter.h), and all system calls
// including those of the clock (system_call_counter.h). The rare readings of CPU times by the
// SuspensionGuard are not counted. Exits with 1 if any of these is not zero.
//
// BM_Descriptors: the cost of describing the scene, also as a share of the detection time of the
// cheapest arm in this scene (goal: below 1 %). BM_CopyForTheLane: the cost of a frame whose
// boxes the shadow lane requested, which is rare.
#include <benchmark/benchmark.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <limits>
#include <optional>
#include <thread>
#include <vector>

#include "engine_client/adaptive/adaptive_factory.h"
#include "engine_client/adaptive/box_tap.h"
#include "engine_client/adaptive/descriptor_estimator.h"
#include "engine_client/adaptive/guards/suspension_guard.h"
#include "engine_client/scene/box_scenes.h"
#include "engine_client/telemetry/common/sample_queue.h"
#include "tests/bench/programs/system_call_counter.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/malloc_counter.h"
#include "tests/support/wait_counter.h"

namespace sweepstake {
namespace {

constexpr int kWarmUpFrames = 20'000;
constexpr int kCountedFrames = 20'000;

class NullBackend final : public BroadPhase {
 public:
  std::string_view name() const override { return "Null"; }
  uint32_t version() const override { return 1; }
  void DoBuild(std::span<const Aabb>) override {}
  void DoUpdate(std::span<const Aabb>) override {}
  void DoFindPairs(PairBuffer&) override {}
  uint64_t aabb_check_count() const override { return 0; }
  size_t native_bytes() const override { return 0; }
};

// Empties the queue every millisecond until it is destroyed.
class Reader {
 public:
  explicit Reader(SampleQueue& queue)
      : thread_([this, &queue] {
          while (!stop_.load(std::memory_order_relaxed)) {
            while (queue.Pop()) {
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
          }
        }) {}
  ~Reader() {
    stop_.store(true, std::memory_order_relaxed);
    thread_.join();
  }

 private:
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

// The frame path and its scene.
class FramePath {
 public:
  FramePath(FrameSink* sink, size_t object_count) : scene_("brownian", object_count, 11) {
    std::vector<std::unique_ptr<BroadPhase>> backends;
    backends.push_back(std::make_unique<NullBackend>());
    adaptive_ = std::move(*AdaptiveFactory::Make({}, std::move(backends), sink, SteadyClock()));
    for (int frame = 0; frame < kWarmUpFrames; ++frame) Frame();
  }

  void Frame() {
    adaptive_->BeginFrame();
    benchmark::DoNotOptimize(adaptive_->FindPairs(scene_.boxes()).data());
    adaptive_->EndFrame({.frame_time_ns = 16'666'667});
  }

 private:
  BoxScene scene_;
  std::unique_ptr<AdaptiveBroadPhase> adaptive_;
};

struct Faults {
  uint64_t allocation_count = 0;
  uint64_t wait_count = 0;
  std::optional<uint64_t> system_call_count;  // nullopt if this system cannot count them
};

template <typename Frame>
Faults CountFaults(const Frame& frame) {
  const auto run = [&] {
    for (int i = 0; i < kCountedFrames; ++i) frame();
  };
  Faults faults;
  const uint64_t before = test_support::ThreadAllocationCount() + test_support::ThreadMallocCount();
  {
    const test_support::WaitCounter waits;
    run();
    faults.wait_count = waits.count();
  }
  faults.allocation_count =
      test_support::ThreadAllocationCount() + test_support::ThreadMallocCount() - before;
  const uint64_t start_ns = SteadyClock().NowNs();
  if (const auto calls = test_support::CountSystemCalls(run)) {
    const uint64_t elapsed_ns = SteadyClock().NowNs() - start_ns;
    const uint64_t cpu_reading_count = 2 * (1 + elapsed_ns / SuspensionGuard::kBaselineNs);
    faults.system_call_count = calls->count - std::min(calls->count, cpu_reading_count);
  }
  return faults;
}

bool any_fault = false;  // a benchmark function cannot return a failure

void Report(const Faults& faults, benchmark::State& state) {
  const auto per_frame = [](uint64_t count) { return static_cast<double>(count) / kCountedFrames; };
  state.counters["allocations"] = per_frame(faults.allocation_count);
  state.counters["waits"] = per_frame(faults.wait_count);
  if (faults.system_call_count) {
    state.counters["system_calls"] = per_frame(*faults.system_call_count);
  } else {
    state.SetLabel("system calls were not counted: this system has no seccomp");
  }
  any_fault = any_fault || faults.allocation_count + faults.wait_count > 0 ||
              faults.system_call_count.value_or(0) > 0;
}

void Measure(FrameSink* sink, benchmark::State& state) {
  FramePath path(sink, static_cast<size_t>(state.range(0)));
  while (state.KeepRunning()) path.Frame();
  Report(CountFaults([&path] { path.Frame(); }), state);
}

void BM_FrameWithoutSink(benchmark::State& state) { Measure(nullptr, state); }

void BM_FrameIntoAFullQueue(benchmark::State& state) {
  SampleQueue queue(4096);
  Measure(&queue, state);
}

// The filter that counts system calls stops only this thread, so end the reader first.
void BM_FrameIntoAQueueThatIsRead(benchmark::State& state) {
  SampleQueue queue(4096);
  FramePath path(&queue, static_cast<size_t>(state.range(0)));
  {
    const Reader reader(queue);
    while (state.KeepRunning()) path.Frame();
  }
  Report(CountFaults([&path] { path.Frame(); }), state);
}

BENCHMARK(BM_FrameWithoutSink)->Arg(1000)->Arg(100'000);
BENCHMARK(BM_FrameIntoAFullQueue)->Arg(1000)->Arg(100'000);
BENCHMARK(BM_FrameIntoAQueueThatIsRead)->Arg(1000)->Arg(100'000)->UseRealTime();

// Returns the median detection time of the cheapest arm in this scene.
double CheapestFrameNs(size_t object_count) {
  constexpr int kFrames = 20;
  double cheapest_ns = std::numeric_limits<double>::max();
  for (const char* arm : {"Grid", "SAP", "AxisSweep", "DBVT", "Tracy", "KDTree"}) {
    BoxScene scene("brownian", object_count, 11);
    const auto backend = std::move(*MakeBroadPhase(arm));
    PairBuffer pairs;
    std::vector<double> times;
    backend->Build(scene.boxes());
    for (int frame = 0; frame < kFrames; ++frame) {
      scene.Step();
      const uint64_t start_ns = SteadyClock().NowNs();
      backend->Update(scene.boxes());
      pairs.Clear();
      backend->FindPairs(pairs);
      times.push_back(static_cast<double>(SteadyClock().NowNs() - start_ns));
    }
    std::nth_element(times.begin(), times.begin() + kFrames / 2, times.end());
    cheapest_ns = std::min(cheapest_ns, times[kFrames / 2]);
  }
  return cheapest_ns;
}

void BM_Descriptors(benchmark::State& state) {
  const auto object_count = static_cast<size_t>(state.range(0));
  const BoxScene scene("brownian", object_count, 11);
  DescriptorEstimator estimator;
  const auto observe = [&] {
    estimator.Observe(scene.boxes());
    if (estimator.ready()) benchmark::DoNotOptimize(estimator.Take());
  };
  const uint64_t start_ns = SteadyClock().NowNs();
  while (state.KeepRunning()) observe();
  const auto elapsed_ns = static_cast<double>(SteadyClock().NowNs() - start_ns);
  state.counters["percent_of_frame"] =
      100 * elapsed_ns / static_cast<double>(state.iterations()) / CheapestFrameNs(object_count);
  Report(CountFaults(observe), state);
}
BENCHMARK(BM_Descriptors)->Arg(1000)->Arg(10'000);

void BM_CopyForTheLane(benchmark::State& state) {
  const auto object_count = static_cast<size_t>(state.range(0));
  const BoxScene scene("brownian", object_count, 11);
  BoxTap tap;
  tap.Reserve(BoxTap::kMaxSlots, object_count);
  const auto copy = [&] {
    if (tap.complete()) tap.Request(BoxTap::kMaxSlots);
    tap.OnFrame(scene.boxes(), {}, SteadyClock());
  };
  while (state.KeepRunning()) copy();
  Report(CountFaults(copy), state);
}
BENCHMARK(BM_CopyForTheLane)->Arg(1000)->Arg(10'000);

// Measures how much of a frame's cost the clock causes: a frame reads it twice.
void BM_TwoReadingsOfTheClock(benchmark::State& state) {
  Clock& clock = SteadyClock();
  while (state.KeepRunning()) {
    benchmark::DoNotOptimize(clock.NowNs());
    benchmark::DoNotOptimize(clock.NowNs());
  }
}
BENCHMARK(BM_TwoReadingsOfTheClock);

// Checks that the counter counts, because a counter that stays 0 would hide every error.
bool CounterSeesSystemCalls() {
  const auto calls = test_support::CountSystemCalls([] { (void)syscall(SYS_getppid); });
  return !calls || (calls->count == 1 && calls->last_number == SYS_getppid);
}

}  // namespace
}  // namespace sweepstake

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  if (!sweepstake::CounterSeesSystemCalls()) {
    std::fputs("The counter of system calls does not work.\n", stderr);
    return 1;
  }
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  if (sweepstake::any_fault)
    std::fputs("The frame path allocated memory, blocked or made a system call.\n", stderr);
  return sweepstake::any_fault ? 1 : 0;
}
