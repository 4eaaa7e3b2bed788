// Measures the cost of proxies in cases that matter to engines, as ratios that `judge.py proxies`
// compares with goals.toml. Prints one JSON document.
//
// The two sides of a ratio take turns in one run and are compared by their fastest turns, because
// other programs can only slow a turn down. All boxes move a little in each frame; pairs come from
// KDTree. `--quick` makes everything small, as a smoke test.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <memory>
#include <vector>

#include "engine_client/scene/random.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/proxy_set.h"

namespace sweepstake {
namespace {

struct Sizes {
  size_t ignored = 10'000;
  size_t movers = 2'000;
  size_t few_static = 20'000;
  size_t many_static = 2'000'000;
  size_t added = 100'000;
  size_t churned = 10'000;
  size_t churn = 1'000'000;
  size_t tile = 18'000;
  int turns = 15;
};
constexpr Sizes kQuick = {500, 100, 500, 5'000, 1'000, 500, 5'000, 500, 2};

constexpr CollisionFilter kDebris = {.category = 4, .mask = ~4U};

template <typename Work>
double Milliseconds(const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

struct Fastest {
  double a_ms = std::numeric_limits<double>::infinity();
  double b_ms = std::numeric_limits<double>::infinity();
};

// Runs a() and b() in turns. Each returns the milliseconds of one turn.
template <typename A, typename B>
Fastest TakeTurns(int turns, const A& a, const B& b) {
  Fastest fastest;
  for (int turn = 0; turn < turns; ++turn) {
    fastest.a_ms = std::min(fastest.a_ms, a());
    fastest.b_ms = std::min(fastest.b_ms, b());
  }
  return fastest;
}

void Print(const char* figure, const Fastest& fastest, const char* a, const char* b) {
  std::printf("%s  \"%s\": %.4f,\n  \"%s\": %.4f,\n  \"%s\": %.4f", ",\n", figure,
              fastest.a_ms / fastest.b_ms, a, fastest.a_ms, b, fastest.b_ms);
}

// Returns the edge of a cube with the density of suite-b.
float SideFor(size_t count) { return std::cbrt(static_cast<float>(count)); }

Aabb BoxWithin(SequentialRandom& random, float from, float to) {
  Aabb box;
  for (int axis = 0; axis < 3; ++axis) {
    const float center = random.Between(from, to);
    const float half = random.Between(0.2F, 0.4F);
    box.min[axis] = center - half;
    box.max[axis] = center + half;
  }
  return box;
}

std::vector<Aabb> BoxesWithin(size_t count, float side, uint64_t seed) {
  SequentialRandom random(seed);
  std::vector<Aabb> boxes;
  for (size_t k = 0; k < count; ++k) boxes.push_back(BoxWithin(random, 0, side));
  return boxes;
}

// Moving boxes with a broad phase.
class World {
 public:
  World(std::vector<Aabb> boxes, const CollisionFilter& filter)
      : boxes_(std::move(boxes)), handles_(boxes_.size()) {
    const ProxyOptions options{.filter = filter};
    proxies.AddMany(boxes_, std::span(&options, 1), handles_);
    backend_->Build(proxies.moving_boxes());
  }

  // Returns the milliseconds of moving all boxes and finding all pairs.
  double Frame() {
    step_ = -step_;
    for (Aabb& box : boxes_) {
      box.min[0] += step_;
      box.max[0] += step_;
    }
    return Milliseconds([&] {
      proxies.Move(handles_, boxes_);
      backend_->Update(proxies.moving_boxes());
      pairs_.Clear();
      backend_->FindPairs(pairs_);
      pair_count = proxies.Resolve(pairs_.pairs()).size();
    });
  }

  ProxySet proxies;
  size_t pair_count = 0;

 private:
  std::vector<Aabb> boxes_;
  std::vector<ProxyHandle> handles_;
  std::unique_ptr<BroadPhase> backend_ = std::move(*MakeBroadPhase("KDTree"));
  PairBuffer pairs_;
  float step_ = 0.0078125F;
};

// Returns the time of a search without filters, for boxes that are all in one place or apart. A
// design that filters after the search, or at each check in the leaves, would pay this time.
double SearchMilliseconds(const char* backend_name, const std::vector<Aabb>& boxes) {
  const auto backend = std::move(*MakeBroadPhase(backend_name));
  PairBuffer pairs;
  double fastest = std::numeric_limits<double>::infinity();
  for (int turn = 0; turn < 3; ++turn) {
    backend->Build(boxes);
    pairs.Clear();
    fastest = std::min(fastest, Milliseconds([&] { backend->FindPairs(pairs); }));
  }
  return fastest;
}

void IgnoredInOnePlace(const Sizes& sizes) {
  const std::vector<Aabb> together(sizes.ignored, Aabb{{0, 0, 0}, {1, 1, 1}});
  std::vector<Aabb> apart;
  for (size_t k = 0; k < sizes.ignored; ++k) {
    const auto x = static_cast<float>(2 * (k % 22));
    const auto y = static_cast<float>(2 * (k / 22 % 22));
    const auto z = static_cast<float>(2 * (k / 484));
    apart.push_back({{x, y, z}, {x + 1, y + 1, z + 1}});
  }
  World a(together, kDebris);
  World b(apart, kDebris);
  // Adds proxies that the movers do not ignore, so that a search is necessary. They are too far
  // away to be found.
  for (ProxySet* const proxies : {&a.proxies, &b.proxies}) {
    proxies->Add({{-9, -9, -9}, {-8, -8, -8}});
    proxies->Add({{-9, -9, -9}, {-8, -8, -8}}, {.is_static = true});
  }
  Print("ignored_coincident_ratio",
        TakeTurns(
            20 * sizes.turns, [&] { return a.Frame(); }, [&] { return b.Frame(); }),
        "ignored_coincident_ms", "ignored_apart_ms");
  std::printf(",\n  \"all_pairs_first_ms\": %.4f,\n  \"all_checks_ms\": %.4f",
              SearchMilliseconds("KDTree", together), SearchMilliseconds("BruteForce", apart));
}

// Around the movers both worlds have the same boxes; the large one has more boxes elsewhere.
void MoversAmongStatic(const Sizes& sizes) {
  const float side = SideFor(sizes.few_static);
  const std::vector<Aabb> movers = BoxesWithin(sizes.movers, side, 1);
  World few(movers, {});
  World many(movers, {});
  for (const Aabb& box : BoxesWithin(sizes.few_static, side, 2)) {
    few.proxies.Add(box, {.is_static = true});
    many.proxies.Add(box, {.is_static = true});
  }
  SequentialRandom random(3);
  const float far = SideFor(sizes.many_static);
  for (size_t k = sizes.few_static; k < sizes.many_static; ++k) {
    Aabb box = BoxWithin(random, 0, far);
    box.min[0] += side + 1;
    box.max[0] += side + 1;
    many.proxies.Add(box, {.is_static = true});
  }
  few.Frame();
  many.Frame();
  Print("many_static_ratio",
        TakeTurns(
            20 * sizes.turns, [&] { return many.Frame(); }, [&] { return few.Frame(); }),
        "many_static_ms", "few_static_ms");
}

// Both worlds have the same density, and the same number of movers anywhere in them.
void MoversApart(const char* figure, const char* many_ms, const char* few_ms, size_t movers,
                 const Sizes& sizes) {
  const auto make = [&](size_t statics) {
    const float side = SideFor(statics);
    auto world = std::make_unique<World>(BoxesWithin(movers, side, 9), CollisionFilter{});
    for (const Aabb& box : BoxesWithin(statics, side, 10)) {
      world->proxies.Add(box, {.is_static = true});
    }
    world->Frame();
    return world;
  };
  const auto few = make(sizes.few_static);
  const auto many = make(sizes.many_static);
  Print(figure,
        TakeTurns(
            20 * sizes.turns, [&] { return many->Frame(); }, [&] { return few->Frame(); }),
        many_ms, few_ms);
}

void SingleAdds(const Sizes& sizes) {
  const std::vector<Aabb> boxes = BoxesWithin(sizes.added, SideFor(sizes.added), 4);
  std::vector<ProxyHandle> handles(boxes.size());
  const ProxyOptions options;
  const auto singly = [&] {
    ProxySet proxies;
    return Milliseconds([&] {
      for (size_t k = 0; k < boxes.size(); ++k) handles[k] = proxies.Add(boxes[k], options);
    });
  };
  const auto together = [&] {
    ProxySet proxies;
    return Milliseconds([&] { proxies.AddMany(boxes, std::span(&options, 1), handles); });
  };
  Print("single_add_ratio", TakeTurns(sizes.turns, singly, together), "single_adds_ms",
        "one_batch_ms");
}

double QueryMilliseconds(ProxySet& proxies, float side) {
  SequentialRandom random(6);
  std::vector<ProxyHandle> found;
  RayHit hit;
  proxies.PrepareQueries();
  return Milliseconds([&] {
    for (int k = 0; k < 2000; ++k) {
      proxies.QueryBox(BoxWithin(random, 0, side), {}, found);
      const Aabb start = BoxWithin(random, 0, side);
      Ray ray{{start.min[0], start.min[1], start.min[2]},
              {random.Symmetric(), random.Symmetric(), random.Symmetric()}};
      ray.max_distance = 20;
      (void)proxies.CastRayNearest(ray, {}, hit).ok();
    }
  });
}

// Adds and removes proxies, every second of them static, with queries in between.
void QueriesAfterChurn(const Sizes& sizes) {
  const float side = SideFor(sizes.churned);
  std::vector<Aabb> boxes = BoxesWithin(sizes.churned, side, 5);
  ProxySet churned;
  std::vector<ProxyHandle> handles;
  for (size_t k = 0; k < boxes.size(); ++k) {
    handles.push_back(churned.Add(boxes[k], {.is_static = k % 2 == 0}));
  }
  SequentialRandom random(7);
  for (size_t change = 0; change < sizes.churn; ++change) {
    const size_t k = random.Below(boxes.size());
    churned.Remove(handles[k]);
    boxes[k] = BoxWithin(random, 0, side);
    handles[k] = churned.Add(boxes[k], {.is_static = k % 2 == 0});
    if (change % 97 == 0) churned.PrepareQueries();
  }
  ProxySet fresh;
  for (size_t k = 0; k < boxes.size(); ++k) fresh.Add(boxes[k], {.is_static = k % 2 == 0});
  Print("churned_query_ratio",
        TakeTurns(
            4 * sizes.turns, [&] { return QueryMilliseconds(churned, side); },
            [&] { return QueryMilliseconds(fresh, side); }),
        "churned_queries_ms", "fresh_queries_ms");
}

// Static proxies that fill a cube with the density of suite-b.
class StaticWorld {
 public:
  explicit StaticWorld(size_t count) : side(SideFor(count)) {
    for (const Aabb& box : BoxesWithin(count, side, 11)) {
      handles_.push_back(proxies.Add(box, {.is_static = true}));
    }
    proxies.PrepareQueries();
  }

  // Returns the milliseconds of a frame that removes one proxy and adds one.
  double ChangeOne() {
    const size_t k = random_.Below(handles_.size());
    const Aabb box = BoxWithin(random_, 0, side);
    return Milliseconds([&] {
      proxies.Remove(handles_[k]);
      handles_[k] = proxies.Add(box, {.is_static = true});
      proxies.PrepareQueries();
    });
  }

  float side;
  ProxySet proxies;

 private:
  std::vector<ProxyHandle> handles_;
  SequentialRandom random_{12};
};

void OneChange(const Sizes& sizes) {
  StaticWorld few(sizes.few_static);
  StaticWorld many(sizes.many_static);
  const auto frames = [](StaticWorld& world) {
    double sum = 0;
    for (int frame = 0; frame < 20; ++frame) sum += world.ChangeOne();
    return sum / 20;
  };
  Print("one_change_many_static_ratio",
        TakeTurns(
            4 * sizes.turns, [&] { return frames(many); }, [&] { return frames(few); }),
        "one_change_many_static_ms", "one_change_few_static_ms");
}

// Adds tiles of static boxes next to a world of them, and removes each four tiles later. The
// slowest of these frames is compared with the first frame, which sorts the world.
void StreamedTiles(const Sizes& sizes) {
  ProxySet fresh;
  for (const Aabb& box : BoxesWithin(sizes.many_static, SideFor(sizes.many_static), 11)) {
    fresh.Add(box, {.is_static = true});
  }
  const double sort_ms = Milliseconds([&] { fresh.PrepareQueries(); });
  StaticWorld world(sizes.many_static);
  const float tile_side = SideFor(sizes.tile);
  const ProxyOptions options{.is_static = true};
  std::vector<std::vector<ProxyHandle>> tiles;
  double worst_ms = 0;
  for (int k = 0; k < 60; ++k) {
    std::vector<Aabb> boxes = BoxesWithin(sizes.tile, tile_side, 13 + static_cast<uint64_t>(k));
    for (Aabb& box : boxes) {
      box.min[0] += world.side;
      box.max[0] += world.side;
      box.min[1] += tile_side * static_cast<float>(k % 8);
      box.max[1] += tile_side * static_cast<float>(k % 8);
    }
    tiles.emplace_back(boxes.size());
    worst_ms = std::max(worst_ms, Milliseconds([&] {
                          world.proxies.AddMany(boxes, std::span(&options, 1), tiles.back());
                          world.proxies.PrepareQueries();
                        }));
    if (k < 4) continue;
    worst_ms = std::max(worst_ms, Milliseconds([&] {
                          world.proxies.RemoveMany(tiles[static_cast<size_t>(k) - 4]);
                          world.proxies.PrepareQueries();
                        }));
  }
  Print("stream_worst_frame_ratio", {worst_ms, sort_ms}, "stream_worst_frame_ms", "sort_all_ms");
  Print("streamed_query_ratio",
        TakeTurns(
            4 * sizes.turns, [&] { return QueryMilliseconds(world.proxies, world.side); },
            [&] { return QueryMilliseconds(fresh, world.side); }),
        "streamed_queries_ms", "unstreamed_queries_ms");
}

void Snapshots(const Sizes& sizes) {
  World world(BoxesWithin(sizes.churned, SideFor(sizes.churned), 8), {});
  world.Frame();
  std::vector<std::byte> snapshot(world.proxies.snapshot_bytes());
  const Fastest fastest = TakeTurns(
      10 * sizes.turns,
      [&] { return Milliseconds([&] { (void)world.proxies.Save(snapshot).ok(); }); },
      [&] { return Milliseconds([&] { (void)world.proxies.Restore(snapshot).ok(); }); });
  std::printf(
      ",\n  \"snapshot_bytes_per_box\": %.2f,\n  \"save_ms\": %.4f,\n  \"restore_ms\": %.4f",
      static_cast<double>(snapshot.size()) / static_cast<double>(sizes.churned), fastest.a_ms,
      fastest.b_ms);
}

void MeasureAll(const Sizes& sizes) {
  std::printf("{\"command\": \"proxy_ratios_bench\"");
  IgnoredInOnePlace(sizes);
  MoversAmongStatic(sizes);
  MoversApart("apart_many_static_ratio", "apart_many_static_ms", "apart_few_static_ms",
              sizes.movers, sizes);
  MoversApart("ten_apart_many_static_ratio", "ten_apart_many_static_ms", "ten_apart_few_static_ms",
              10, sizes);
  SingleAdds(sizes);
  QueriesAfterChurn(sizes);
  OneChange(sizes);
  StreamedTiles(sizes);
  Snapshots(sizes);
  std::printf("\n}\n");
}

}  // namespace
}  // namespace sweepstake

int main(int argc, char** argv) {
  const bool quick = argc == 2 && std::strcmp(argv[1], "--quick") == 0;
  if (argc > 1 && !quick) {
    std::fprintf(stderr, "Usage: proxy_ratios_bench [--quick]\n");
    return 2;
  }
  sweepstake::MeasureAll(quick ? sweepstake::kQuick : sweepstake::Sizes{});
  return 0;
}
