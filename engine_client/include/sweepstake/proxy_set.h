// What an engine needs around a broad phase: objects by stable handle, collision filters, static
// objects, pair events and queries. It works with any backend and with AdaptiveBroadPhase, whose
// arms may change underneath:
//
//   ProxySet proxies({.pair_events = true});
//   const ProxyHandle player = proxies.Add(box, {.filter = {.category = 2, .mask = 5}});
//   ... each frame ...
//   proxies.Move(player, box);
//   const auto pairs = proxies.Resolve(adaptive.FindPairs(proxies.moving_boxes()));
//   for (const ProxyPair& pair : proxies.added()) ...
//
// Moving proxies stand in one dense array, which the broad phase takes; a freed place is a box that
// does not take part until it is used again, so that adding and removing is an update like any
// other. Static ones stand in a tree of their own, in which the moving ones are sought: they are
// never paired with one another, and while they rest only the moving ones cost.
//
// Thread safety: one thread at a time, but for queries after PrepareQueries. Ownership: spans that
// are handed out belong to the set. Units: world units of the caller. A box that does not take part
// (aabb.h) is taken as it is: it overlaps nothing and no query finds it until it is moved.
// Memory: 56 bytes per place and, for the kinds that have a tree (static ones, and all once
// queried), 100 more; 16 bytes per pair, 24 where they are sorted.
//
// Cost, for 10,000 moving boxes of suite-b and their 14,500 pairs: 5 ns per Move; Resolve 13 µs
// with filters, nothing without, 70 µs where pairs are sorted and 120 µs with events; 0.28 ms with
// 100,000 static boxes around them and 29,400 pairs more, 0.19 ms on two threads. Queries among all
// of these: 0.33 µs for a box that finds five, 0.33 µs for the first hit of a ray, 1.1 µs for all
// twelve; the first one after a change 20 µs more for the moving ones, 0.27 ms for the static ones.
// (tests/bench/proxies_bench.cc)
//
// Errors: a handle that is null, stale (its proxy was removed) or of another set that happens to
// have none such is answered with false, null or nothing, and changes nothing; never with another
// proxy. std::bad_alloc when memory or the 2^31 − 1 places of a kind are out; the set is then as
// before the call.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "sweepstake/aabb.h"
#include "sweepstake/executor.h"
#include "sweepstake/status.h"

namespace sweepstake {

// Which proxy. `index` is its id in pairs for as long as it lives: the place in moving_boxes(), or
// kStaticProxyBit and a place among the static ones. Ids are used again, `generation` tells the
// owners apart (a place has 2^31 of them). All zero is null and belongs to no proxy.
struct ProxyHandle {
  uint32_t index = 0;
  uint32_t generation = 0;

  bool is_null() const { return generation == 0; }
  // The comparison of the result with 0 is the compiler's own.
  // NOLINTNEXTLINE(modernize-use-nullptr)
  friend auto operator<=>(const ProxyHandle&, const ProxyHandle&) = default;
};
static_assert(sizeof(ProxyHandle) == 8);

// Set in the ids of static proxies, and only there.
inline constexpr uint32_t kStaticProxyBit = 0x80000000U;

// What a proxy is, and what it meets, as sets of bits.
struct CollisionFilter {
  uint32_t category = 1;
  uint32_t mask = ~0U;

  friend bool operator==(const CollisionFilter&, const CollisionFilter&) = default;
};

// Whether each one's category is in the other's mask.
constexpr bool Passes(const CollisionFilter& a, const CollisionFilter& b) {
  return (a.category & b.mask) != 0 && (b.category & a.mask) != 0;
}

struct ProxyOptions {
  CollisionFilter filter = {};
  // Paired with moving proxies only. Fixed for the life of the proxy.
  bool is_static = false;
  uint64_t user = 0;  // the caller's own word, for example an index or a pointer

  friend bool operator==(const ProxyOptions&, const ProxyOptions&) = default;
};

// a.index < b.index.
struct ProxyPair {
  ProxyHandle a;
  ProxyHandle b;

  // NOLINTNEXTLINE(modernize-use-nullptr)
  friend auto operator<=>(const ProxyPair&, const ProxyPair&) = default;
};

// The points origin + t · direction for t from 0 to max_distance. All values must be finite.
// Without a direction (all zero) it is the point itself.
struct Ray {
  float origin[3];
  float direction[3];  // distances are in multiples of its length
  float max_distance = std::numeric_limits<float>::max();
};

struct RayHit {
  ProxyHandle proxy;
  float distance = 0;  // where the ray enters the box; 0 where it starts inside or on a face

  friend bool operator==(const RayHit&, const RayHit&) = default;
};

struct ProxySetOptions {
  bool sorted_pairs = false;  // Resolve returns ascending pairs, whatever the backend
  bool pair_events = false;   // fills added() and removed(); the pairs are then sorted too
  // Runs the parts of the search among static proxies (executor.h); borrowed, must outlive the set.
  Executor* executor = nullptr;
};

class ProxySet {
 public:
  explicit ProxySet(const ProxySetOptions& options = {});
  ~ProxySet();
  ProxySet(ProxySet&&) noexcept;
  ProxySet& operator=(ProxySet&&) noexcept;

  // Takes part from the next Resolve and the next query on. O(1) for a moving proxy; the tree of
  // the static ones is refitted once for all changes since, O(static ones).
  ProxyHandle Add(const Aabb& box, const ProxyOptions& options = {});
  // False for a handle without a proxy, as below.
  bool Remove(ProxyHandle handle);

  // O(1). A static proxy may be moved as well, at the cost of an Add.
  bool Move(ProxyHandle handle, const Aabb& box);
  // boxes[k] to handles[k]. False, and nothing is moved, where one of them has no proxy. REQUIRES:
  // equal sizes.
  bool Move(std::span<const ProxyHandle> handles, std::span<const Aabb> boxes);
  bool SetFilter(ProxyHandle handle, const CollisionFilter& filter);
  bool SetUser(ProxyHandle handle, uint64_t user);

  bool is_alive(ProxyHandle handle) const;
  // Valid until the next Add; null without a proxy.
  const Aabb* box(ProxyHandle handle) const;
  std::optional<ProxyOptions> options(ProxyHandle handle) const;
  // The proxy that has this id now, as in a pair of Resolve; null where there is none.
  ProxyHandle handle(uint32_t id) const;
  // Living proxies.
  size_t moving_count() const;
  size_t static_count() const;

  // What the broad phase takes, id by id; it grows at the end and does not shrink. Valid until the
  // next Add.
  std::span<const Aabb> moving_boxes() const;

  // Once per frame: from the pairs a broad phase found in moving_boxes(), those that pass their
  // filters, and then the pairs of moving with static proxies; of ids, a < b. In the order of the
  // backend and of the search, or ascending (ProxySetOptions). Valid until the next Resolve, and as
  // long as `moving_pairs` is. REQUIRES: no Add, Remove or Move since the broad phase took the
  // boxes.
  std::span<const OverlapPair> Resolve(std::span<const OverlapPair> moving_pairs);

  // Of the latest Resolve against the one before it, ascending; empty without pair_events. A pair
  // of which one has been removed since, or whose filters do not pass any more, is among removed(),
  // with the handles it was added with. Valid until the next Resolve.
  std::span<const ProxyPair> added() const;
  std::span<const ProxyPair> removed() const;

  // Queries, over moving and static proxies alike, as they are now: the first one after a change
  // refits the tree of the kind that changed, O(proxies of it). A proxy is found when its filter
  // and the query's pass. `out` and `hits` are overwritten; their order is the same on every
  // machine.

  // All that overlap `box`, by ascending index.
  void QueryBox(const Aabb& box, const CollisionFilter& filter, std::vector<ProxyHandle>& out);
  // All hits within max_distance, by ascending distance, equal ones by index; faces are closed.
  // kInvalidArgument for a ray that is not finite or has a negative max_distance.
  Status CastRay(const Ray& ray, const CollisionFilter& filter, std::vector<RayHit>& hits);
  // The first of those; `hit` has a null proxy where there is none.
  Status CastRayNearest(const Ray& ray, const CollisionFilter& filter, RayHit& hit);
  // Does what the first query would. Until the next change any number of threads may then query at
  // the same time.
  void PrepareQueries();

  size_t native_bytes() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sweepstake
