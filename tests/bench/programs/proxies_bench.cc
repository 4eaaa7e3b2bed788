// Measures the cost of proxies per frame and per query in addition to the broad phase: 10,000
// moving boxes of suite-b, with and without 100,000 static boxes (the first frame of suite-b).
//
// Only the call in the name is measured (manual time); KDTree finds the pairs.
#include <benchmark/benchmark.h>

#include <chrono>
#include <memory>
#include <utility>
#include <vector>

#include "engine_client/scene/random.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/pair_sorter.h"
#include "sweepstake/proxy_set.h"
#include "sweepstake/scene.h"

namespace sweepstake {
namespace {

constexpr uint32_t kMoving = 10'000;
constexpr uint32_t kStatic = 100'000;
constexpr float kStaticSide = 46.4F;
constexpr int kFrames = 200;

std::unique_ptr<Scene> SuiteB(uint32_t count) {
  SceneOptions options;
  options.object_count = count;
  return std::move(*MakeScene("suite-b", options));
}

class Game {
 public:
  Game(const ProxySetOptions& options, uint32_t static_count, const CollisionFilter& filter)
      : proxies(options), scene_(SuiteB(kMoving)), backend_(std::move(*MakeBroadPhase("KDTree"))) {
    for (const Aabb& box : scene_->aabbs()) handles_.push_back(proxies.Add(box, {filter}));
    if (static_count > 0) AddStatic(*SuiteB(static_count));
    backend_->Build(proxies.moving_boxes());
  }

  void Step() {
    scene_->Step();
    proxies.Move(handles_, scene_->aabbs());
  }

  std::span<const OverlapPair> FindPairs() {
    backend_->Update(proxies.moving_boxes());
    pairs_.Clear();
    backend_->FindPairs(pairs_);
    return pairs_.pairs();
  }

  PairBuffer& pairs() { return pairs_; }

  ProxySet proxies;

 private:
  void AddStatic(const Scene& scene) {
    for (const Aabb& box : scene.aabbs()) proxies.Add(box, {.is_static = true});
  }

  std::unique_ptr<Scene> scene_;
  std::unique_ptr<BroadPhase> backend_;
  std::vector<ProxyHandle> handles_;
  PairBuffer pairs_;
};

template <typename Timed>
void TimeAlone(benchmark::State& state, const Timed& timed) {
  const auto start = std::chrono::steady_clock::now();
  timed();
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  state.SetIterationTime(taken.count());
}

void Resolve(benchmark::State& state, const ProxySetOptions& options,
             const CollisionFilter& filter = {}) {
  Game game(options, static_cast<uint32_t>(state.range(0)), filter);
  size_t pair_count = 0;
  for ([[maybe_unused]] auto _ : state) {
    game.Step();
    const auto found = game.FindPairs();
    TimeAlone(state, [&] { pair_count = game.proxies.Resolve(found).size(); });
  }
  state.counters["pairs"] = static_cast<double>(pair_count);
  state.counters["bytes"] = static_cast<double>(game.proxies.native_bytes());
}

void ResolveAll(benchmark::State& state) { Resolve(state, {}); }
void ResolveFiltered(benchmark::State& state) { Resolve(state, {}, {2, ~0U}); }
void ResolveSorted(benchmark::State& state) { Resolve(state, {.sorted_pairs = true}); }
void ResolveWithEvents(benchmark::State& state) { Resolve(state, {.pair_events = true}); }
void ResolveOnTwoThreads(benchmark::State& state) {
  const auto pool = MakeThreadPool(2);
  Resolve(state, {.executor = pool.get()});
}
BENCHMARK(ResolveAll)
    ->Arg(0)
    ->Arg(kStatic)
    ->UseManualTime()
    ->Iterations(kFrames)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK(ResolveFiltered)
    ->Arg(0)
    ->Arg(kStatic)
    ->UseManualTime()
    ->Iterations(kFrames)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK(ResolveSorted)
    ->Arg(0)
    ->Arg(kStatic)
    ->UseManualTime()
    ->Iterations(kFrames)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK(ResolveWithEvents)
    ->Arg(0)
    ->Arg(kStatic)
    ->UseManualTime()
    ->Iterations(kFrames)
    ->Unit(benchmark::kMicrosecond);
BENCHMARK(ResolveOnTwoThreads)
    ->Arg(kStatic)
    ->UseManualTime()
    ->Iterations(kFrames)
    ->Unit(benchmark::kMicrosecond);

void MoveAll(benchmark::State& state) {
  Game game({}, 0, {});
  for ([[maybe_unused]] auto _ : state) game.Step();
}
BENCHMARK(MoveAll)->Unit(benchmark::kMicrosecond);

// Measures the first query after all moving proxies moved, or after one static proxy moved.
void RefreshMoving(benchmark::State& state) {
  Game game({}, 0, {});
  for ([[maybe_unused]] auto _ : state) {
    game.Step();
    TimeAlone(state, [&] { game.proxies.PrepareQueries(); });
  }
}
void RefreshStatic(benchmark::State& state) {
  Game game({}, kStatic, {});
  const ProxyHandle one = game.proxies.handle(kStaticProxyBit);
  Aabb box = *game.proxies.box(one);
  for ([[maybe_unused]] auto _ : state) {
    std::swap(box.min[0], box.max[0]);  // valid and invalid in turn
    game.proxies.Move(one, box);
    TimeAlone(state, [&] { game.proxies.PrepareQueries(); });
  }
}
BENCHMARK(RefreshMoving)->UseManualTime()->Iterations(kFrames)->Unit(benchmark::kMicrosecond);
BENCHMARK(RefreshStatic)->UseManualTime()->Iterations(kFrames)->Unit(benchmark::kMicrosecond);

void SortPairs(benchmark::State& state) {
  Game game({}, 0, {});
  PairSorter sorter;
  for ([[maybe_unused]] auto _ : state) {
    game.Step();
    game.FindPairs();
    TimeAlone(state, [&] { sorter.Sort(game.pairs().pairs()); });
  }
}
BENCHMARK(SortPairs)->UseManualTime()->Iterations(kFrames)->Unit(benchmark::kMicrosecond);

// Returns a box at a random place in the world of the 100,000 static boxes, which contains the
// 10,000 moving boxes.
Aabb Anywhere(SequentialRandom& random, float half_extent) {
  Aabb box;
  for (int axis = 0; axis < 3; ++axis) {
    const float center = random.Between(0, kStaticSide);
    box.min[axis] = center - half_extent;
    box.max[axis] = center + half_extent;
  }
  return box;
}

void QueryBox(benchmark::State& state) {
  Game game({}, kStatic, {});
  SequentialRandom random(1);
  std::vector<ProxyHandle> found;
  size_t found_count = 0;
  for ([[maybe_unused]] auto _ : state) {
    game.proxies.QueryBox(Anywhere(random, 0.5F), {}, found);
    found_count += found.size();
  }
  state.counters["found"] =
      benchmark::Counter(static_cast<double>(found_count), benchmark::Counter::kAvgIterations);
}
BENCHMARK(QueryBox)->Unit(benchmark::kNanosecond);

Ray AnyRay(SequentialRandom& random, float max_distance) {
  const Aabb start = Anywhere(random, 0);
  Ray ray{};
  for (int axis = 0; axis < 3; ++axis) {
    ray.origin[axis] = start.min[axis];
    ray.direction[axis] = random.Symmetric();
  }
  ray.max_distance = max_distance;
  return ray;
}

void CastRay(benchmark::State& state) {
  Game game({}, kStatic, {});
  SequentialRandom random(1);
  std::vector<RayHit> hits;
  size_t hit_count = 0;
  for ([[maybe_unused]] auto _ : state) {
    benchmark::DoNotOptimize(game.proxies.CastRay(AnyRay(random, 20), {}, hits).ok());
    hit_count += hits.size();
  }
  state.counters["hits"] =
      benchmark::Counter(static_cast<double>(hit_count), benchmark::Counter::kAvgIterations);
}
void CastRayNearest(benchmark::State& state) {
  Game game({}, kStatic, {});
  SequentialRandom random(1);
  RayHit hit;
  for ([[maybe_unused]] auto _ : state) {
    benchmark::DoNotOptimize(game.proxies.CastRayNearest(AnyRay(random, 20), {}, hit).ok());
  }
}
BENCHMARK(CastRay)->Unit(benchmark::kNanosecond);
BENCHMARK(CastRayNearest)->Unit(benchmark::kNanosecond);

}  // namespace
}  // namespace sweepstake
