#include <algorithm>
#include <memory>

#include "engine_client/adaptive/invalid_box_counter.h"
#include "engine_client/c_api/boundary.h"
#include "engine_client/c_api/executor.h"
#include "engine_client/c_api/live.h"
#include "engine_client/c_api/sized_struct.h"
#include "sweepstake/adaptive_broad_phase.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/pair_sorter.h"

using sweepstake::BroadPhase;
using sweepstake::BroadPhaseNames;
using sweepstake::PairBuffer;
using sweepstake::PairSorter;
using sweepstake::SteadyClock;
using namespace sweepstake::c_api;  // NOLINT(google-build-using-namespace)

namespace {

struct World {
  static constexpr swp_kind kKind = SWP_KIND_WORLD;
  static constexpr std::string_view kName = "world";

  std::unique_ptr<sweepstake::Executor> executor;  // outlives the backend
  std::unique_ptr<BroadPhase> backend;
  std::unique_ptr<PairSorter> sorter;  // null: pairs stay in the backend's order
  PairBuffer pairs;
  bool built = false;
  bool searched = false;
  uint32_t object_count = 0;
  sweepstake::InvalidBoxCounter invalid_boxes;
  uint64_t take_time_ns = 0;
  uint64_t search_time_ns = 0;
};

// Passes the boxes to the backend by calling `take`. If it throws, the world counts as not built.
template <typename Take>
void TakeBoxes(World& world, uint32_t count, const Take& take) {
  world.built = false;
  world.searched = false;
  world.pairs.Clear();
  const uint64_t start_ns = SteadyClock().NowNs();
  take();
  world.take_time_ns = SteadyClock().NowNs() - start_ns;
  world.search_time_ns = 0;
  world.object_count = count;
  world.built = true;
}

swp_result Search(World& world) {
  world.built = false;
  const uint64_t start_ns = SteadyClock().NowNs();
  world.backend->FindPairs(world.pairs);
  if (world.backend->pairs_exceeded()) return TooManyPairs();
  if (world.sorter) world.sorter->Sort(world.pairs.pairs());
  world.search_time_ns = SteadyClock().NowNs() - start_ns;
  world.built = true;
  world.searched = true;
  return SWP_OK;
}

constexpr swp_world_options kWorldDefaults = {sizeof(swp_world_options), 0, nullptr, 0, 0, 0};

swp_result CreateWorld(const char* backend, const swp_world_options& options, swp_world** world) {
  if (options.sorted_pairs > 1 || options.reserved != 0) {
    return Fail(SWP_INVALID_ARGUMENT, "sorted_pairs must be 0 or 1, reserved 0");
  }
  auto created = std::make_unique<World>();
  const swp_result wrong = MakeExecutor(options.thread_count, options.executor, created->executor);
  if (wrong != SWP_OK) return wrong;
  auto made = sweepstake::MakeBroadPhase(backend, {created->executor.get(), options.max_pairs});
  if (!made.ok()) return ToResult(made.status());
  created->backend = std::move(*made);
  if (options.sorted_pairs != 0) created->sorter = std::make_unique<PairSorter>();
  Publish(std::move(created), world);
  return SWP_OK;
}

swp_result NotBuilt() { return Fail(SWP_FAILED_PRECONDITION, "call swp_world_build first"); }

}  // namespace

struct swp_world final : Handle<World> {
  using Handle::Handle;
};

uint32_t swp_backend_count(void) { return static_cast<uint32_t>(BroadPhaseNames().size()); }

// Returns the name's data without copying: the names are literals, so they end with NUL.
const char* swp_backend_name(uint32_t index) {
  const auto names = BroadPhaseNames();
  return index < names.size() ? names[index].data() : nullptr;
}

swp_result swp_world_options_init(swp_world_options* options) {
  return Give("swp_world_options", kWorldDefaults, options);
}

swp_result swp_world_create(const char* backend, const swp_world_options* options,
                            swp_world** world) {
  if (backend == nullptr || world == nullptr) return NullArgument("backend and world");
  return Guard([&] {
    swp_world_options known = kWorldDefaults;
    const swp_result wrong = TakeOptions("swp_world_options", options, known);
    return wrong != SWP_OK ? wrong : CreateWorld(backend, known, world);
  });
}

void swp_world_destroy(swp_world* world) { Destroy(world); }

swp_result swp_world_build(swp_world* world, const swp_aabb* boxes, uint32_t count) {
  return Use(world, [&](World& live) {
    const swp_result wrong = CheckBoxes(boxes, count);
    if (wrong != SWP_OK) return wrong;
    TakeBoxes(live, count, [&] { live.backend->Build(ToBoxes(boxes, count)); });
    live.invalid_boxes.CountAll(ToBoxes(boxes, count));
    return kOk;
  });
}

swp_result swp_world_update(swp_world* world, const swp_aabb* boxes, uint32_t count) {
  return Use(world, [&](World& live) {
    if (const swp_result wrong = CheckBoxes(boxes, count); wrong != SWP_OK) return wrong;
    if (!live.built) return NotBuilt();
    TakeBoxes(live, count, [&] { live.backend->Update(ToBoxes(boxes, count)); });
    live.invalid_boxes.Follow(ToBoxes(boxes, count));
    return kOk;
  });
}

swp_result swp_world_find_pairs(swp_world* world) {
  return Use(world, [&](World& live) {
    if (!live.built) return NotBuilt();
    return live.searched ? kOk : Search(live);
  });
}

swp_result swp_world_pairs(const swp_world* world, const swp_pair** pairs, uint64_t* count) {
  return Use(world, [&](const World& live) {
    if (!live.searched) return Fail(SWP_FAILED_PRECONDITION, "call swp_world_find_pairs first");
    return GivePairs(live.pairs.pairs(), pairs, count);
  });
}

swp_result swp_world_counters(const swp_world* world, swp_counters* counters) {
  return Use(world, [&](const World& live) {
    swp_counters now{};
    now.object_count = live.object_count;
    now.aabb_check_count = live.built ? live.backend->aabb_check_count() : 0;
    now.native_bytes = live.backend->native_bytes();
    now.detection_time_ns = live.take_time_ns + live.search_time_ns;
    now.pair_count = live.pairs.size();
    now.backend_version = live.backend->version();
    now.invalid_box_count = live.invalid_boxes.count();
    return Give("swp_counters", now, counters);
  });
}
