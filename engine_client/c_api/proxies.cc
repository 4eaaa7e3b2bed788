// Proxies: the set of proxy_set.h behind handles of C, and the results of its latest calls.
#include <algorithm>
#include <bit>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "engine_client/c_api/boundary.h"
#include "engine_client/c_api/executor.h"
#include "engine_client/c_api/sized_struct.h"
#include "sweepstake/pair_buffer.h"
#include "sweepstake/proxy_set.h"

using sweepstake::Aabb;
using sweepstake::CollisionFilter;
using sweepstake::OverlapPair;
using sweepstake::PairBuffer;
using sweepstake::ProxyHandle;
using sweepstake::ProxyOptions;
using sweepstake::ProxyPair;
using sweepstake::ProxySet;
using sweepstake::ProxySetOptions;
using sweepstake::Ray;
using sweepstake::RayHit;
using namespace sweepstake::c_api;  // NOLINT(google-build-using-namespace)

// The structs cross the boundary by pointer cast.
static_assert(sizeof(swp_proxy) == sizeof(ProxyHandle));
static_assert(std::endian::native == std::endian::little);  // index in the low bits of swp_proxy
static_assert(sizeof(swp_proxy_pair) == sizeof(ProxyPair));
static_assert(sizeof(swp_filter) == sizeof(CollisionFilter));
static_assert(sizeof(swp_ray) == sizeof(Ray) && sizeof(swp_ray) == 28);
static_assert(SWP_STATIC_PROXY_BIT == sweepstake::kStaticProxyBit);

struct swp_proxies {
  explicit swp_proxies(std::unique_ptr<sweepstake::Executor> threads, ProxySetOptions options)
      : executor(std::move(threads)), set((options.executor = executor.get(), options)) {}

  std::unique_ptr<sweepstake::Executor> executor;  // outlives the set
  ProxySet set;
  std::optional<std::span<const OverlapPair>> pairs;  // absent: nothing resolved yet
  PairBuffer own_pairs;  // the pairs, where they are the caller's memory
  std::vector<ProxyHandle> found;
  std::vector<RayHit> hits;
};

namespace {

swp_result NoSuchProxy() {
  return Fail(SWP_NOT_FOUND, "no proxy has this handle: it was removed, or never was one");
}

ProxyHandle ToHandle(swp_proxy proxy) { return std::bit_cast<ProxyHandle>(proxy); }
swp_proxy ToProxy(ProxyHandle handle) { return std::bit_cast<swp_proxy>(handle); }
swp_ray_hit ToHit(const RayHit& hit) { return {ToProxy(hit.proxy), hit.distance, 0}; }
CollisionFilter ToFilter(const swp_filter& filter) { return {filter.category, filter.mask}; }
CollisionFilter FilterOrAll(const swp_filter* filter) {
  return filter == nullptr ? CollisionFilter{~0U, ~0U} : ToFilter(*filter);
}

swp_result CheckTruth(std::string_view message, uint32_t value) {
  return value > 1 ? Fail(SWP_INVALID_ARGUMENT, message) : SWP_OK;
}

swp_result CheckOptions(const swp_proxies_options& options) {
  const swp_result wrong = CheckTruth("pair_events must be 0 or 1", options.pair_events);
  return wrong != SWP_OK ? wrong : CheckTruth("sorted_pairs must be 0 or 1", options.sorted_pairs);
}

constexpr swp_proxies_options kDefaults = {sizeof(swp_proxies_options), 0, 0, 0, nullptr};

swp_result CreateProxies(const swp_proxies_options& options, swp_proxies** proxies) {
  std::unique_ptr<sweepstake::Executor> executor;
  const swp_result wrong = MakeExecutor(options.thread_count, options.executor, executor);
  if (wrong != SWP_OK) return wrong;
  ProxySetOptions chosen;
  chosen.sorted_pairs = options.sorted_pairs != 0;
  chosen.pair_events = options.pair_events != 0;
  *proxies = std::make_unique<swp_proxies>(std::move(executor), chosen).release();
  return SWP_OK;
}

swp_result CheckOutput(const swp_proxies* proxies, const void* out, uint64_t capacity,
                       const uint64_t* count) {
  if (proxies == nullptr || count == nullptr) return NullArgument("proxies and the count");
  if (out == nullptr && capacity > 0) return NullArgument("the buffer");
  return SWP_OK;
}

swp_result CheckMovingPairs(std::span<const OverlapPair> pairs, size_t moving_count) {
  for (const OverlapPair& pair : pairs) {
    if (pair.a < pair.b && pair.b < moving_count) continue;
    return Fail(SWP_INVALID_ARGUMENT,
                "a pair that is not of the boxes of swp_proxies_moving_boxes");
  }
  return SWP_OK;
}

// Copies the pairs if the set returns the caller's own array, since the caller may change it.
void Keep(swp_proxies& proxies, std::span<const OverlapPair> resolved,
          std::span<const OverlapPair> given) {
  proxies.pairs = resolved;
  if (resolved.data() != given.data()) return;
  proxies.own_pairs.Clear();
  OverlapPair* const end = proxies.own_pairs.EnsureRoom(resolved.size());
  std::copy(resolved.begin(), resolved.end(), end);
  proxies.own_pairs.Advance(resolved.size());
  proxies.pairs = std::as_const(proxies.own_pairs).pairs();
}

}  // namespace

swp_result swp_proxies_options_init(swp_proxies_options* options) {
  return Give("swp_proxies_options", kDefaults, options);
}

swp_result swp_proxies_create(const swp_proxies_options* options, swp_proxies** proxies) {
  if (proxies == nullptr) return NullArgument("proxies");
  return Guard([&] {
    swp_proxies_options known = kDefaults;
    swp_result wrong = TakeOptions("swp_proxies_options", options, known);
    if (wrong == SWP_OK) wrong = CheckOptions(known);
    return wrong != SWP_OK ? wrong : CreateProxies(known, proxies);
  });
}

void swp_proxies_destroy(swp_proxies* proxies) { delete proxies; }

swp_result swp_proxies_add(swp_proxies* proxies, const swp_aabb* box,
                           const swp_proxy_options* options, swp_proxy* proxy) {
  if (proxies == nullptr || box == nullptr || proxy == nullptr) {
    return NullArgument("proxies, box and proxy");
  }
  ProxyOptions chosen;
  if (options != nullptr) {
    if ((options->flags & ~uint32_t{SWP_PROXY_STATIC}) != 0 || options->reserved != 0) {
      return Fail(SWP_INVALID_ARGUMENT, "flags may hold SWP_PROXY_STATIC only, reserved must be 0");
    }
    chosen = {ToFilter(options->filter), (options->flags & SWP_PROXY_STATIC) != 0, options->user};
  }
  return Guard([&] {
    *proxy = ToProxy(proxies->set.Add(ToBoxes(box, 1)[0], chosen));
    return static_cast<swp_result>(SWP_OK);
  });
}

swp_result swp_proxies_remove(swp_proxies* proxies, swp_proxy proxy) {
  if (proxies == nullptr) return NullArgument("proxies");
  return proxies->set.Remove(ToHandle(proxy)) ? SWP_OK : NoSuchProxy();
}

swp_result swp_proxies_move(swp_proxies* proxies, const swp_proxy* moved, const swp_aabb* boxes,
                            uint32_t count) {
  if (proxies == nullptr) return NullArgument("proxies");
  if ((moved == nullptr || boxes == nullptr) && count > 0) return NullArgument("moved and boxes");
  const std::span handles{reinterpret_cast<const ProxyHandle*>(moved), count};
  return proxies->set.Move(handles, ToBoxes(boxes, count)) ? SWP_OK : NoSuchProxy();
}

swp_result swp_proxies_set_filter(swp_proxies* proxies, swp_proxy proxy, const swp_filter* filter) {
  if (proxies == nullptr) return NullArgument("proxies");
  return proxies->set.SetFilter(ToHandle(proxy), FilterOrAll(filter)) ? SWP_OK : NoSuchProxy();
}

swp_result swp_proxies_set_user(swp_proxies* proxies, swp_proxy proxy, uint64_t user) {
  if (proxies == nullptr) return NullArgument("proxies");
  return proxies->set.SetUser(ToHandle(proxy), user) ? SWP_OK : NoSuchProxy();
}

swp_result swp_proxies_get(const swp_proxies* proxies, swp_proxy proxy, swp_aabb* box,
                           swp_proxy_options* options) {
  if (proxies == nullptr) return NullArgument("proxies");
  const Aabb* const found = proxies->set.box(ToHandle(proxy));
  if (found == nullptr) return NoSuchProxy();
  if (box != nullptr) std::memcpy(box, found, sizeof *box);
  if (options != nullptr) {
    const auto chosen = proxies->set.options(ToHandle(proxy));
    *options = {{chosen->filter.category, chosen->filter.mask},
                chosen->is_static ? uint32_t{SWP_PROXY_STATIC} : 0U,
                0,
                chosen->user};
  }
  return SWP_OK;
}

swp_result swp_proxies_handle(const swp_proxies* proxies, uint32_t id, swp_proxy* proxy) {
  if (proxies == nullptr || proxy == nullptr) return NullArgument("proxies and proxy");
  const ProxyHandle handle = proxies->set.handle(id);
  if (handle.is_null()) return Fail(SWP_NOT_FOUND, "no proxy has this id");
  *proxy = ToProxy(handle);
  return SWP_OK;
}

swp_result swp_proxies_counts(const swp_proxies* proxies, uint32_t* moving_count,
                              uint32_t* static_count, uint64_t* native_bytes) {
  if (proxies == nullptr) return NullArgument("proxies");
  if (moving_count != nullptr) *moving_count = static_cast<uint32_t>(proxies->set.moving_count());
  if (static_count != nullptr) *static_count = static_cast<uint32_t>(proxies->set.static_count());
  if (native_bytes != nullptr) *native_bytes = proxies->set.native_bytes();
  return SWP_OK;
}

swp_result swp_proxies_moving_boxes(const swp_proxies* proxies, const swp_aabb** boxes,
                                    uint32_t* count) {
  if (proxies == nullptr || boxes == nullptr || count == nullptr) {
    return NullArgument("proxies, boxes and count");
  }
  const std::span<const Aabb> moving = proxies->set.moving_boxes();
  *boxes = reinterpret_cast<const swp_aabb*>(moving.data());
  *count = static_cast<uint32_t>(moving.size());
  return SWP_OK;
}

swp_result swp_proxies_resolve(swp_proxies* proxies, const swp_pair* moving_pairs,
                               uint64_t moving_pair_count, swp_pair* pairs, uint64_t capacity,
                               uint64_t* pair_count) {
  swp_result wrong = CheckOutput(proxies, pairs, capacity, pair_count);
  if (wrong != SWP_OK) return wrong;
  if (moving_pairs == nullptr && moving_pair_count > 0) return NullArgument("moving_pairs");
  const std::span given{reinterpret_cast<const OverlapPair*>(moving_pairs), moving_pair_count};
  wrong = CheckMovingPairs(given, proxies->set.moving_boxes().size());
  if (wrong != SWP_OK) return wrong;
  return Guard([&] {
    proxies->pairs.reset();
    Keep(*proxies, proxies->set.Resolve(given), given);
    return WriteAll(*proxies->pairs, pairs, capacity, pair_count);
  });
}

swp_result swp_proxies_copy_pairs(const swp_proxies* proxies, swp_pair* pairs, uint64_t capacity,
                                  uint64_t* pair_count) {
  const swp_result wrong = CheckOutput(proxies, pairs, capacity, pair_count);
  if (wrong != SWP_OK) return wrong;
  if (!proxies->pairs) return Fail(SWP_FAILED_PRECONDITION, "call swp_proxies_resolve first");
  return WriteAll(*proxies->pairs, pairs, capacity, pair_count);
}

swp_result swp_proxies_added(const swp_proxies* proxies, swp_proxy_pair* added, uint64_t capacity,
                             uint64_t* count) {
  const swp_result wrong = CheckOutput(proxies, added, capacity, count);
  return wrong != SWP_OK ? wrong : WriteAll(proxies->set.added(), added, capacity, count);
}

swp_result swp_proxies_removed(const swp_proxies* proxies, swp_proxy_pair* removed,
                               uint64_t capacity, uint64_t* count) {
  const swp_result wrong = CheckOutput(proxies, removed, capacity, count);
  return wrong != SWP_OK ? wrong : WriteAll(proxies->set.removed(), removed, capacity, count);
}

swp_result swp_proxies_query_box(swp_proxies* proxies, const swp_aabb* box,
                                 const swp_filter* filter, swp_proxy* found, uint64_t capacity,
                                 uint64_t* count) {
  const swp_result wrong = CheckOutput(proxies, found, capacity, count);
  if (wrong != SWP_OK) return wrong;
  if (box == nullptr) return NullArgument("box");
  return Guard([&] {
    proxies->set.QueryBox(ToBoxes(box, 1)[0], FilterOrAll(filter), proxies->found);
    return WriteAll(std::span(proxies->found), found, capacity, count);
  });
}

swp_result swp_proxies_cast_ray(swp_proxies* proxies, const swp_ray* ray, const swp_filter* filter,
                                swp_ray_hit* hits, uint64_t capacity, uint64_t* count) {
  const swp_result wrong = CheckOutput(proxies, hits, capacity, count);
  if (wrong != SWP_OK) return wrong;
  if (ray == nullptr) return NullArgument("ray");
  return Guard([&] {
    const Ray& cast = *reinterpret_cast<const Ray*>(ray);
    const auto status = proxies->set.CastRay(cast, FilterOrAll(filter), proxies->hits);
    if (!status.ok()) return ToResult(status);
    *count = proxies->hits.size();
    if (*count > capacity) return TooFewPlaces();
    std::transform(proxies->hits.begin(), proxies->hits.end(), hits, ToHit);
    return static_cast<swp_result>(SWP_OK);
  });
}

swp_result swp_proxies_cast_ray_nearest(swp_proxies* proxies, const swp_ray* ray,
                                        const swp_filter* filter, swp_ray_hit* hit,
                                        uint32_t* found) {
  if (proxies == nullptr || ray == nullptr || hit == nullptr || found == nullptr) {
    return NullArgument("proxies, ray, hit and found");
  }
  return Guard([&] {
    RayHit nearest;
    const Ray& cast = *reinterpret_cast<const Ray*>(ray);
    const auto status = proxies->set.CastRayNearest(cast, FilterOrAll(filter), nearest);
    if (!status.ok()) return ToResult(status);
    *found = nearest.proxy.is_null() ? 0 : 1;
    if (*found != 0) *hit = ToHit(nearest);
    return static_cast<swp_result>(SWP_OK);
  });
}
