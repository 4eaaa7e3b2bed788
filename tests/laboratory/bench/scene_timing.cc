#include "tests/laboratory/bench/scene_timing.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <optional>
#include <thread>

#include "sweepstake/simd.h"
#include "tests/laboratory/game/frame_block.h"

namespace sweepstake::cli {
namespace {

using std::chrono::steady_clock;

// The boxes of a frame that are passed to one contestant.
class ShownBoxes {
 public:
  void Show(std::span<const Aabb> boxes, bool valid_only) {
    ids_.clear();
    boxes_.assign(boxes.begin(), boxes.end());
    if (!valid_only || std::all_of(boxes.begin(), boxes.end(), IsValid)) return;
    boxes_.clear();
    for (uint32_t id = 0; id < boxes.size(); ++id) {
      if (!IsValid(boxes[id])) continue;
      boxes_.push_back(boxes[id]);
      ids_.push_back(id);
    }
  }
  std::span<const Aabb> boxes() const { return boxes_; }
  void RestoreIds(PairBuffer& pairs) const {
    if (boxes_.empty() || ids_.empty()) return;
    for (OverlapPair& pair : pairs.pairs()) pair = {ids_[pair.a], ids_[pair.b]};
  }

 private:
  std::vector<Aabb> boxes_;
  std::vector<uint32_t> ids_;  // indices of the passed boxes; empty if all are passed
};

// Evicts all other data from the caches by reading and writing its own memory.
class CacheFiller {
 public:
  void Fill() {
    constexpr size_t kCacheLine = 64;
    for (size_t at = 0; at < bytes_.size(); at += kCacheLine) ++bytes_[at];
  }

 private:
  std::vector<uint8_t> bytes_ = std::vector<uint8_t>(size_t{32} << 20);
};

double MillisecondsSince(steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(steady_clock::now() - start).count();
}

// Wakes all threads of the executor. Returns when each of them has begun a part of a job.
void Wake(Executor* executor) {
  if (executor == nullptr) return;
  struct Barrier {
    const size_t expected;
    std::atomic<size_t> arrived{0};
  } barrier{executor->thread_count()};
  executor->RunParts(
      barrier.expected,
      [](void* context, size_t) {
        auto& shared = *static_cast<Barrier*>(context);
        shared.arrived.fetch_add(1);
        while (shared.arrived.load() < shared.expected) std::this_thread::yield();
      },
      &barrier);
}

// Selects a contestant's instruction set before its turn. The destructor selects the set that was
// in use when this object was created.
class SimdTurns {
 public:
  SimdTurns() = default;
  SimdTurns(const SimdTurns&) = delete;
  SimdTurns& operator=(const SimdTurns&) = delete;
  ~SimdTurns() { (void)UseSimdTarget(before_); }

  void Choose(const Contestant& contestant) const {
    (void)UseSimdTarget(contestant.simd.empty() ? before_ : contestant.simd);
  }

 private:
  const std::string_view before_ = SimdTarget();
};

// Steps one contestant through the scene and times it.
class Run {
 public:
  explicit Run(const Contestant& contestant) : contestant_(contestant) {}

  void Build(std::span<const Aabb> boxes) {
    shown_.Show(boxes, contestant_.valid_boxes_only);
    const auto start = steady_clock::now();
    contestant_.broad_phase->Build(shown_.boxes());
    contestant_.broad_phase->FindPairs(pairs_);
    used_ms_ += MillisecondsSince(start);
  }

  bool active() const { return !timing_.capped; }
  uint64_t step_count() const { return timing_.step_ms.size(); }

  void Step(std::span<const Aabb> boxes, bool measured) {
    shown_.Show(boxes, contestant_.valid_boxes_only);
    pairs_.Clear();
    Wake(contestant_.executor);
    const auto start = steady_clock::now();
    contestant_.broad_phase->Update(shown_.boxes());
    contestant_.broad_phase->FindPairs(pairs_);
    const double time_ms = MillisecondsSince(start);
    shown_.RestoreIds(pairs_);
    Note(time_ms, measured);
  }

  ContestantTiming Finish() {
    if (timing_.measured_count == 0) timing_.measured_count = step_count();
    timing_.aabb_checks_mean = static_cast<double>(check_count_) /
                               static_cast<double>(std::max<uint64_t>(timing_.measured_count, 1));
    return std::move(timing_);
  }

 private:
  void Note(double time_ms, bool measured) {
    timing_.step_ms.push_back(time_ms);
    timing_.step_pairs.push_back(FingerprintOf(pairs_.pairs()));
    used_ms_ += time_ms;
    timing_.capped = used_ms_ > 1000 * contestant_.cap_s;
    if (!measured) return;
    ++timing_.measured_count;
    check_count_ += contestant_.broad_phase->aabb_check_count();
    const uint64_t bytes = contestant_.broad_phase->native_bytes();
    timing_.bytes = std::max(timing_.bytes, bytes);
    timing_.bytes_with_pairs =
        std::max<uint64_t>(timing_.bytes_with_pairs, bytes + pairs_.capacity_bytes());
  }

  const Contestant& contestant_;
  ShownBoxes shown_;
  PairBuffer pairs_;
  ContestantTiming timing_;
  double used_ms_ = 0;
  uint64_t check_count_ = 0;
};

void RunBlock(const FrameBlock& block, uint64_t first_step, uint64_t warmup, Run& run,
              CacheFiller* caches, const std::function<void(uint64_t)>& on_step) {
  for (size_t i = 0; i < block.step_count() && run.active(); ++i) {
    if (caches != nullptr) caches->Fill();
    run.Step(block.BoxesOf(i), first_step + i > warmup);
    on_step(first_step + i);
  }
}

}  // namespace

std::vector<ContestantTiming> TimeScene(Scene& scene, std::span<const Contestant> contestants,
                                        const TimingPlan& plan,
                                        const std::function<void(size_t, uint64_t)>& on_step) {
  std::vector<Run> runs(contestants.begin(), contestants.end());
  const SimdTurns simd;
  for (size_t i = 0; i < runs.size(); ++i) {
    simd.Choose(contestants[i]);
    runs[i].Build(scene.aabbs());
  }
  std::optional<CacheFiller> caches;
  if (plan.cold) caches.emplace();
  FrameBlock block;
  size_t turn = 0;
  const uint64_t steps = plan.warmup + plan.frames;
  for (uint64_t done = 0; done < steps; done += block.step_count(), ++turn) {
    block.Fill(scene, steps - done);
    for (size_t i = 0; i < runs.size(); ++i) {
      const size_t index = (turn + i) % runs.size();
      simd.Choose(contestants[index]);
      RunBlock(block, done + 1, plan.warmup, runs[index], caches ? &*caches : nullptr,
               [&](uint64_t step) { on_step(index, step); });
    }
  }
  std::vector<ContestantTiming> timings;
  timings.reserve(runs.size());
  for (Run& run : runs) timings.push_back(run.Finish());
  return timings;
}

}  // namespace sweepstake::cli
