// The C functions for sets of proxies (proxy_set.h).
#include <algorithm>
#include <bit>
#include <cstring>
#include <memory>
#include <optional>
#include <span>

#include "engine_client/c_api/executor.h"
#include "engine_client/c_api/live.h"
#include "engine_client/c_api/sized_struct.h"
#include "sweepstake/proxy_set.h"

using sweepstake::Aabb;
using sweepstake::BoxSweep;
using sweepstake::CollisionFilter;
using sweepstake::OverlapPair;
using sweepstake::ProxyHandle;
using sweepstake::ProxyOptions;
using sweepstake::ProxyPair;
using sweepstake::ProxySet;
using sweepstake::ProxySetOptions;
using sweepstake::Ray;
using sweepstake::RayHit;
using sweepstake::Sphere;
using sweepstake::Status;
using namespace sweepstake::c_api;  // NOLINT(google-build-using-namespace)

// The C structs and the C++ structs have the same layout, because pointers to one are cast to the
// other.
static_assert(sizeof(swp_proxy) == sizeof(ProxyHandle));
static_assert(std::endian::native == std::endian::little);  // index in the low bits of swp_proxy
static_assert(sizeof(swp_proxy_pair) == sizeof(ProxyPair));
static_assert(sizeof(swp_filter) == sizeof(CollisionFilter));
static_assert(sizeof(swp_ray) == sizeof(Ray) && sizeof(swp_ray) == 28);
static_assert(sizeof(swp_sphere) == sizeof(Sphere) && sizeof(swp_sphere) == 16);
static_assert(sizeof(swp_box_sweep) == sizeof(BoxSweep) && sizeof(swp_box_sweep) == 36);
static_assert(SWP_STATIC_PROXY_BIT == sweepstake::kStaticProxyBit);

namespace {

struct Proxies {
  static constexpr swp_kind kKind = SWP_KIND_PROXIES;
  static constexpr std::string_view kName = "proxies";

  Proxies(std::unique_ptr<sweepstake::Executor> threads, ProxySetOptions options, uint64_t most)
      : executor(std::move(threads)),
        set((options.executor = executor.get(), options)),
        max_pairs(most) {}

  std::unique_ptr<sweepstake::Executor> executor;  // outlives the set
  ProxySet set;
  const uint64_t max_pairs;                           // of a resolve; 0: no limit
  std::optional<std::span<const OverlapPair>> pairs;  // absent: there was no resolve yet
};

swp_result NoSuchProxy() {
  return Fail(SWP_NOT_FOUND, "no proxy has this handle: it was removed or never existed");
}

ProxyHandle ToHandle(swp_proxy proxy) { return std::bit_cast<ProxyHandle>(proxy); }
swp_proxy ToProxy(ProxyHandle handle) { return std::bit_cast<swp_proxy>(handle); }
CollisionFilter ToFilter(const swp_filter& filter) { return {filter.category, filter.mask}; }
CollisionFilter FilterOrDefault(const swp_filter* filter) {
  return filter == nullptr ? CollisionFilter{} : ToFilter(*filter);
}

swp_result CheckTruth(std::string_view message, uint32_t value) {
  return value > 1 ? Fail(SWP_INVALID_ARGUMENT, message) : SWP_OK;
}

swp_result CheckOptions(const swp_proxies_options& options) {
  const swp_result wrong = CheckTruth("pair_events must be 0 or 1", options.pair_events);
  if (wrong != SWP_OK) return wrong;
  if (!(options.event_margin >= 0) || options.reserved != 0) {
    return Fail(SWP_INVALID_ARGUMENT, "event_margin must not be negative, and reserved must be 0");
  }
  return CheckTruth("sorted_pairs must be 0 or 1", options.sorted_pairs);
}

constexpr swp_proxies_options kProxyDefaults = {
    sizeof(swp_proxies_options), 0, 0, 0, nullptr, 0, 0, 0};

swp_result CreateProxies(const swp_proxies_options& options, swp_proxies** proxies) {
  std::unique_ptr<sweepstake::Executor> executor;
  const swp_result wrong = MakeExecutor(options.thread_count, options.executor, executor);
  if (wrong != SWP_OK) return wrong;
  ProxySetOptions chosen;
  chosen.sorted_pairs = options.sorted_pairs != 0;
  chosen.pair_events = options.pair_events != 0;
  chosen.event_margin = options.event_margin;
  Publish(std::make_unique<Proxies>(std::move(executor), chosen, options.max_pairs), proxies);
  return SWP_OK;
}

swp_result CheckMovingPairs(std::span<const OverlapPair> pairs, size_t moving_count) {
  for (const OverlapPair& pair : pairs) {
    if (pair.a < pair.b && pair.b < moving_count) continue;
    return Fail(
        SWP_INVALID_ARGUMENT,
        "each pair must have a < b, and both must be indices of boxes of swp_proxies_moving_boxes");
  }
  return SWP_OK;
}

swp_result CheckOptions(const swp_proxy_options* options, uint32_t count) {
  const std::span given(options, options == nullptr ? 0 : count);
  const bool known = std::all_of(given.begin(), given.end(), [](const swp_proxy_options& one) {
    return (one.flags & ~uint32_t{SWP_PROXY_STATIC}) == 0 && one.reserved == 0;
  });
  if (known) return SWP_OK;
  return Fail(SWP_INVALID_ARGUMENT, "flags may hold SWP_PROXY_STATIC only, and reserved must be 0");
}

ProxyOptions ToOptions(const swp_proxy_options& given) {
  return {ToFilter(given.filter), (given.flags & SWP_PROXY_STATIC) != 0, given.user};
}

// Adds proxies. Unless Keep is called, the destructor removes them again, for example if memory
// runs out in the middle.
class Batch {
 public:
  Batch(ProxySet& set, swp_proxy* added) : set_(set), added_(added) {}
  ~Batch() {
    for (uint32_t k = 0; k < count_; ++k) set_.Remove(ToHandle(added_[k]));
  }
  Batch(const Batch&) = delete;
  Batch& operator=(const Batch&) = delete;
  void Add(const Aabb& box, const ProxyOptions& options) {
    added_[count_] = ToProxy(set_.Add(box, options));
    ++count_;
  }
  void Keep() { count_ = 0; }

 private:
  ProxySet& set_;
  swp_proxy* const added_;
  uint32_t count_ = 0;
};

// Returns the result of a query, with a message for SWP_FAILED_PRECONDITION that names the C
// function.
swp_result ToQueryResult(const Status& status) {
  if (status.code() != sweepstake::StatusCode::kFailedPrecondition) return ToResult(status);
  return Fail(SWP_FAILED_PRECONDITION,
              "call swp_proxies_prepare_queries first, and again after every change");
}

// Returns the beginning of the caller's array as an array of RayHit, which is not larger than
// swp_ray_hit.
std::span<RayHit> Packed(swp_ray_hit* hits, uint64_t capacity) {
  static_assert(sizeof(RayHit) <= sizeof(swp_ray_hit));
  return {reinterpret_cast<RayHit*>(hits), capacity};
}

// Converts the hits of Packed in place. It goes from the last to the first, so that each hit is
// read before it is overwritten.
void Unpack(swp_ray_hit* hits, uint64_t count) {
  for (uint64_t k = count; k-- > 0;) {
    RayHit hit;
    std::memcpy(&hit, reinterpret_cast<const RayHit*>(hits) + k, sizeof hit);
    hits[k] = {ToProxy(hit.proxy), hit.distance, 0};
  }
}

}  // namespace

struct swp_proxies final : Handle<Proxies> {
  using Handle::Handle;
};

namespace {

// For each shape, finds the proxies that touch it. Errors call the required arguments
// `names`.
template <typename Shape, typename Given>
swp_result QueryShapes(const swp_proxies* proxies,
                       Status (ProxySet::*query)(std::span<const Shape>, const CollisionFilter&,
                                                 std::span<ProxyHandle>, std::span<size_t>) const,
                       const Given* shapes, uint32_t count, std::string_view names,
                       const swp_filter* filter, swp_proxy* found, uint64_t capacity,
                       uint64_t* ends) {
  return Use(proxies, [&](const Proxies& live) {
    if ((shapes == nullptr || ends == nullptr) && count > 0) return NullArgument(names);
    if (found == nullptr && capacity > 0) return NullArgument("found");
    const std::span asked{reinterpret_cast<const Shape*>(shapes), count};
    const std::span out{reinterpret_cast<ProxyHandle*>(found), capacity};
    const std::span places{reinterpret_cast<size_t*>(ends), count};
    const Status status = (live.set.*query)(asked, FilterOrDefault(filter), out, places);
    if (!status.ok()) return ToQueryResult(status);
    return !places.empty() && places.back() > capacity ? TooFewPlaces() : kOk;
  });
}

// For each moving shape, finds its nearest hit.
template <typename Shape, typename Given>
swp_result CastShapes(const swp_proxies* proxies,
                      Status (ProxySet::*cast)(std::span<const Shape>, const CollisionFilter&,
                                               std::span<RayHit>) const,
                      const Given* shapes, uint32_t count, std::string_view names,
                      const swp_filter* filter, swp_ray_hit* hits) {
  return Use(proxies, [&](const Proxies& live) {
    if ((shapes == nullptr || hits == nullptr) && count > 0) return NullArgument(names);
    const std::span given{reinterpret_cast<const Shape*>(shapes), count};
    const Status status = (live.set.*cast)(given, FilterOrDefault(filter), Packed(hits, count));
    if (!status.ok()) return ToQueryResult(status);
    Unpack(hits, count);
    return kOk;
  });
}

}  // namespace

swp_result swp_proxies_options_init(swp_proxies_options* options) {
  return Give("swp_proxies_options", kProxyDefaults, options);
}

swp_result swp_proxies_create(const swp_proxies_options* options, swp_proxies** proxies) {
  if (proxies == nullptr) return NullArgument("proxies");
  return Guard([&] {
    swp_proxies_options known = kProxyDefaults;
    swp_result wrong = TakeOptions("swp_proxies_options", options, known);
    if (wrong == SWP_OK) wrong = CheckOptions(known);
    return wrong != SWP_OK ? wrong : CreateProxies(known, proxies);
  });
}

void swp_proxies_destroy(swp_proxies* proxies) { Destroy(proxies); }

swp_result swp_proxies_add_many(swp_proxies* proxies, const swp_aabb* boxes,
                                const swp_proxy_options* options, uint32_t count,
                                swp_proxy* added) {
  return Use(proxies, [&](Proxies& live) {
    if ((boxes == nullptr || added == nullptr) && count > 0) return NullArgument("boxes and added");
    if (const swp_result wrong = CheckOptions(options, count); wrong != SWP_OK) return wrong;
    Batch batch(live.set, added);
    for (uint32_t k = 0; k < count; ++k) {
      batch.Add(ToBoxes(boxes, count)[k],
                options == nullptr ? ProxyOptions{} : ToOptions(options[k]));
    }
    batch.Keep();
    return kOk;
  });
}

swp_result swp_proxies_remove_many(swp_proxies* proxies, const swp_proxy* removed, uint32_t count) {
  return Use(proxies, [&](Proxies& live) {
    if (removed == nullptr && count > 0) return NullArgument("removed");
    const std::span given(removed, count);
    const auto lives = [&](swp_proxy proxy) { return live.set.is_alive(ToHandle(proxy)); };
    if (!std::all_of(given.begin(), given.end(), lives)) return NoSuchProxy();
    for (const swp_proxy proxy : given) live.set.Remove(ToHandle(proxy));
    return kOk;
  });
}

swp_result swp_proxies_set_boxes(swp_proxies* proxies, const swp_proxy* moved,
                                 const swp_aabb* boxes, uint32_t count) {
  return Use(proxies, [&](Proxies& live) {
    if ((moved == nullptr || boxes == nullptr) && count > 0) return NullArgument("moved and boxes");
    const std::span handles{reinterpret_cast<const ProxyHandle*>(moved), count};
    return live.set.Move(handles, ToBoxes(boxes, count)) ? kOk : NoSuchProxy();
  });
}

swp_result swp_proxies_set_filter(swp_proxies* proxies, swp_proxy proxy, const swp_filter* filter) {
  return Use(proxies, [&](Proxies& live) {
    return live.set.SetFilter(ToHandle(proxy), FilterOrDefault(filter)) ? kOk : NoSuchProxy();
  });
}

swp_result swp_proxies_set_user(swp_proxies* proxies, swp_proxy proxy, uint64_t user) {
  return Use(proxies, [&](Proxies& live) {
    return live.set.SetUser(ToHandle(proxy), user) ? kOk : NoSuchProxy();
  });
}

swp_result swp_proxies_set_static(swp_proxies* proxies, swp_proxy proxy, uint32_t is_static) {
  return Use(proxies, [&](Proxies& live) {
    const swp_result wrong = CheckTruth("is_static must be 0 or 1", is_static);
    if (wrong != SWP_OK) return wrong;
    return live.set.SetStatic(ToHandle(proxy), is_static != 0) ? kOk : NoSuchProxy();
  });
}

swp_result swp_proxies_set_sleeping(swp_proxies* proxies, swp_proxy proxy, uint32_t is_sleeping) {
  return Use(proxies, [&](Proxies& live) {
    const swp_result wrong = CheckTruth("is_sleeping must be 0 or 1", is_sleeping);
    if (wrong != SWP_OK) return wrong;
    return live.set.SetSleeping(ToHandle(proxy), is_sleeping != 0) ? kOk : NoSuchProxy();
  });
}

swp_result swp_proxies_shift_origin(swp_proxies* proxies, const float* offset) {
  return Use(proxies, [&](Proxies& live) {
    if (offset == nullptr) return NullArgument("offset");
    return ToResult(live.set.ShiftOrigin(offset));
  });
}

swp_result swp_proxies_snapshot_bytes(const swp_proxies* proxies, uint64_t* bytes) {
  return Get(proxies, "bytes", bytes,
             [](const Proxies& live) { return live.set.snapshot_bytes(); });
}

swp_result swp_proxies_save(const swp_proxies* proxies, void* snapshot, uint64_t capacity) {
  return Use(proxies, [&](const Proxies& live) {
    if (snapshot == nullptr) return NullArgument("snapshot");
    return ToResult(live.set.Save({static_cast<std::byte*>(snapshot), capacity}));
  });
}

swp_result swp_proxies_restore(swp_proxies* proxies, const void* snapshot, uint64_t bytes) {
  return Use(proxies, [&](Proxies& live) {
    if (snapshot == nullptr) return NullArgument("snapshot");
    const auto status = live.set.Restore({static_cast<const std::byte*>(snapshot), bytes});
    if (status.ok()) live.pairs.reset();
    return ToResult(status);
  });
}

swp_result swp_proxies_get(const swp_proxies* proxies, swp_proxy proxy, swp_aabb* box,
                           swp_proxy_options* options) {
  return Use(proxies, [&](const Proxies& live) {
    const Aabb* const found = live.set.box(ToHandle(proxy));
    if (found == nullptr) return NoSuchProxy();
    if (box != nullptr) std::memcpy(box, found, sizeof *box);
    if (options == nullptr) return kOk;
    const auto chosen = live.set.options(ToHandle(proxy));
    *options = {{chosen->filter.category, chosen->filter.mask},
                (chosen->is_static ? uint32_t{SWP_PROXY_STATIC} : 0U) |
                    (live.set.is_sleeping(ToHandle(proxy)) ? uint32_t{SWP_PROXY_SLEEPING} : 0U),
                0,
                chosen->user};
    return kOk;
  });
}

swp_result swp_proxies_handle(const swp_proxies* proxies, uint32_t id, swp_proxy* proxy) {
  return Use(proxies, [&](const Proxies& live) {
    if (proxy == nullptr) return NullArgument("proxy");
    const ProxyHandle handle = live.set.handle(id);
    if (handle.is_null()) return Fail(SWP_NOT_FOUND, "no proxy has this id");
    *proxy = ToProxy(handle);
    return kOk;
  });
}

swp_result swp_proxies_counts(const swp_proxies* proxies, uint32_t* moving_count,
                              uint32_t* static_count, uint64_t* native_bytes) {
  return Use(proxies, [&](const Proxies& live) {
    if (moving_count != nullptr) *moving_count = static_cast<uint32_t>(live.set.moving_count());
    if (static_count != nullptr) *static_count = static_cast<uint32_t>(live.set.static_count());
    if (native_bytes != nullptr) *native_bytes = live.set.native_bytes();
  });
}

swp_result swp_proxies_moving_boxes(const swp_proxies* proxies, const swp_aabb** boxes,
                                    uint32_t* count) {
  return Use(proxies, [&](const Proxies& live) {
    if (boxes == nullptr || count == nullptr) return NullArgument("boxes and count");
    const std::span<const Aabb> moving = live.set.moving_boxes();
    *boxes = reinterpret_cast<const swp_aabb*>(moving.data());
    *count = static_cast<uint32_t>(moving.size());
    return kOk;
  });
}

swp_result swp_proxies_resolve(swp_proxies* proxies, const swp_pair* moving_pairs,
                               uint64_t moving_pair_count) {
  return Use(proxies, [&](Proxies& live) {
    if (moving_pairs == nullptr && moving_pair_count > 0) return NullArgument("moving_pairs");
    const std::span given{reinterpret_cast<const OverlapPair*>(moving_pairs), moving_pair_count};
    const swp_result wrong = CheckMovingPairs(given, live.set.moving_boxes().size());
    if (wrong != SWP_OK) return wrong;
    live.pairs.reset();
    const auto pairs = live.set.Resolve(given, live.max_pairs);
    if (live.set.pairs_exceeded()) return TooManyPairs();
    live.pairs = pairs;
    return kOk;
  });
}

swp_result swp_proxies_pairs(const swp_proxies* proxies, const swp_pair** pairs, uint64_t* count) {
  return Use(proxies, [&](const Proxies& live) {
    if (!live.pairs) return Fail(SWP_FAILED_PRECONDITION, "call swp_proxies_resolve first");
    return GivePairs(*live.pairs, pairs, count);
  });
}

swp_result swp_proxies_added(const swp_proxies* proxies, const swp_proxy_pair** added,
                             uint64_t* count) {
  return Use(proxies,
             [&](const Proxies& live) { return GivePairs(live.set.added(), added, count); });
}

swp_result swp_proxies_removed(const swp_proxies* proxies, const swp_proxy_pair** removed,
                               uint64_t* count) {
  return Use(proxies,
             [&](const Proxies& live) { return GivePairs(live.set.removed(), removed, count); });
}

swp_result swp_proxies_prepare_queries(swp_proxies* proxies) {
  return Use(proxies, [](Proxies& live) { live.set.PrepareQueries(); });
}

swp_result swp_proxies_query_boxes(const swp_proxies* proxies, const swp_aabb* boxes,
                                   uint32_t box_count, const swp_filter* filter, swp_proxy* found,
                                   uint64_t capacity, uint64_t* ends) {
  return QueryShapes(proxies, &ProxySet::QueryBoxes, boxes, box_count, "boxes and ends", filter,
                     found, capacity, ends);
}

swp_result swp_proxies_query_spheres(const swp_proxies* proxies, const swp_sphere* spheres,
                                     uint32_t sphere_count, const swp_filter* filter,
                                     swp_proxy* found, uint64_t capacity, uint64_t* ends) {
  return QueryShapes(proxies, &ProxySet::QuerySpheres, spheres, sphere_count, "spheres and ends",
                     filter, found, capacity, ends);
}

swp_result swp_proxies_cast_rays(const swp_proxies* proxies, const swp_ray* rays,
                                 uint32_t ray_count, const swp_filter* filter, swp_ray_hit* hits) {
  return CastShapes(proxies, &ProxySet::CastRays, rays, ray_count, "rays and hits", filter, hits);
}

swp_result swp_proxies_sweep_boxes(const swp_proxies* proxies, const swp_box_sweep* sweeps,
                                   uint32_t sweep_count, const swp_filter* filter,
                                   swp_ray_hit* hits) {
  return CastShapes(proxies, &ProxySet::SweepBoxes, sweeps, sweep_count, "sweeps and hits", filter,
                    hits);
}

swp_result swp_proxies_cast_ray(const swp_proxies* proxies, const swp_ray* ray,
                                const swp_filter* filter, swp_ray_hit* hits, uint64_t capacity,
                                uint64_t* count) {
  return Use(proxies, [&](const Proxies& live) {
    if (ray == nullptr || count == nullptr) return NullArgument("ray and count");
    if (hits == nullptr && capacity > 0) return NullArgument("hits");
    const Ray& cast = *reinterpret_cast<const Ray*>(ray);
    size_t hit_count = 0;
    const auto status =
        live.set.CastRay(cast, FilterOrDefault(filter), Packed(hits, capacity), hit_count);
    if (!status.ok()) return ToQueryResult(status);
    *count = hit_count;
    if (hit_count > capacity) return TooFewPlaces();
    Unpack(hits, hit_count);
    return kOk;
  });
}

swp_result swp_round_outward(const double* min, const double* max, swp_aabb* box) {
  if (min == nullptr || max == nullptr || box == nullptr) return NullArgument("min, max and box");
  const Aabb rounded = sweepstake::RoundOutward(min, max);
  std::memcpy(box, &rounded, sizeof *box);
  return SWP_OK;
}
