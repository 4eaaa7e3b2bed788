// What an engine needs around a broad phase: objects with stable handles, collision filters, static
// objects, pair events and queries. It works with any backend, and with AdaptiveBroadPhase while
// its arms change:
//
//   ProxySet proxies({.pair_events = true});
//   const ProxyHandle player = proxies.Add(box, {.filter = {.category = 2, .mask = 5}});
//   ... each frame ...
//   proxies.Move(player, box);
//   const auto pairs = proxies.Resolve(adaptive.FindPairs(proxies.moving_boxes()));
//   for (const ProxyPair& pair : proxies.added()) ...
//
// Moving proxies are in one dense array, which the broad phase takes. A freed place holds an
// invalid box until it is used again, so that adding and removing are updates like any other. What
// the broad phase need not search stands in trees of its own, in which the others are searched for,
// and has an invalid box in the array:
//   - static proxies, which are never paired with one another and cost nothing while they stay;
//   - sleeping ones, whose pairs with other sleeping and static ones are kept;
//   - moving ones that ignore their own kind (whose category is not in their own mask, as debris
//     that collides with everything but debris): a pile of them costs what it costs apart. There
//     are seven such groups, of filters that may be together; beyond them pairs are filtered after
//     the search.
// Pairs, events and queries never depend on where a proxy stands.
//
// Thread safety: one thread at a time, except for const calls between changes: any number of
// threads may make those at the same time. Ownership: the set owns what its spans refer to. Units:
// world units of the caller. An invalid box (aabb.h) is accepted: it overlaps nothing, and no query
// finds it, until it is moved. Memory: 57 bytes per place, 4 more with events, 24 more for each
// place of a moving proxy once one of them is not in the array, and 32 more for proxies in a tree
// that was searched (after the first query all) with 36 for the largest such tree: 36 in trees of
// more than 60,000, and more where many have come and gone, four times that at most; 16 bytes per
// pair, 24 where pairs are sorted, 8 per kept pair.
//
// Cost (tests/bench/programs/proxies_bench.cc on one thread of AMD Zen 5, measured before there
// were sleeping proxies and groups that ignore their own kind; 10,000 moving boxes of suite-b with
// 14,500 pairs): 5 ns per Move. Resolve takes 13 µs with filters and nothing without, 70 µs where
// pairs are sorted and 120 µs with events; with 100,000 static boxes and their 29,400 pairs 0.28
// ms, on two threads 0.19 ms. A query among all of these takes 0.33 µs for a box that finds five,
// 0.33 µs for the first hit of a ray and 1.1 µs for all twelve; the first query after a change
// takes 20 µs more for the moving proxies. What rests costs a frame what changes of it
// (tests/bench/programs/proxy_ratios_bench.cc, AMD EPYC): 12 µs for a static proxy that is replaced
// among 20,000, 33 µs among 2,000,000, and 5 ms for 18,000 that come together, as a tile of a world
// does. If they stand all over the world, or once half as many have come one by one as there are,
// their tree is sorted anew, for 2,000,000 in 0.25 s; Compact has that done when a game chooses.
//
// Errors: a handle that is null, stale (its proxy was removed) or unknown to this set is answered
// with false, null or nothing, never with another proxy, and changes nothing. If memory or the
// 2^31 − 1 places of a kind are used up, a call ends as OutOfMemory() says (hooks.h); the set is
// then unchanged where its comment does not say otherwise.
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

#include "sweepstake/names/begin.h"

namespace sweepstake {

// A handle names a proxy. `index` is its id in pairs for as long as it lives: its place in
// moving_boxes(), or kStaticProxyBit and its place among those added as static. Ids are used again;
// `generation` distinguishes the owners (a place has 2^31 of them). The null handle is all zero and
// belongs to no proxy.
struct ProxyHandle {
  uint32_t index = 0;
  uint32_t generation = 0;

  bool is_null() const { return generation == 0; }
  // The compiler itself compares the result with 0.
  // NOLINTNEXTLINE(modernize-use-nullptr)
  friend auto operator<=>(const ProxyHandle&, const ProxyHandle&) = default;
};
static_assert(sizeof(ProxyHandle) == 8);

// This bit is set in the ids of proxies that were added as static, and only there.
inline constexpr uint32_t kStaticProxyBit = 0x80000000U;

// What a proxy is (category) and what it collides with (mask), as sets of bits.
struct CollisionFilter {
  uint32_t category = 1;
  uint32_t mask = ~0U;

  friend bool operator==(const CollisionFilter&, const CollisionFilter&) = default;
};

// Returns whether the category of each is in the mask of the other.
constexpr bool Passes(const CollisionFilter& a, const CollisionFilter& b) {
  return (a.category & b.mask) != 0 && (b.category & a.mask) != 0;
}

struct ProxyOptions {
  CollisionFilter filter = {};
  // A static proxy is paired with moving and sleeping ones only. SetStatic changes it.
  bool is_static = false;
  uint64_t user = 0;  // for the caller's use, for example an index or a pointer

  friend bool operator==(const ProxyOptions&, const ProxyOptions&) = default;
};

// A pair of proxies with a.index < b.index.
struct ProxyPair {
  ProxyHandle a;
  ProxyHandle b;

  // NOLINTNEXTLINE(modernize-use-nullptr)
  friend auto operator<=>(const ProxyPair&, const ProxyPair&) = default;
};

// The points origin + t · direction for t from 0 to max_distance. All values must be finite. A
// direction of all zeros makes the ray a single point.
struct Ray {
  float origin[3];
  float direction[3];  // distances are in multiples of its length
  float max_distance = (std::numeric_limits<float>::max)();
};

// The box at all places from where it is to where `translation` takes it. It must be valid, and its
// translation finite.
struct BoxSweep {
  Aabb box;
  float translation[3];
};

// The points up to `radius` from the center. Distances are compared as squares in single precision:
// the radius must be from 0 to kMaxRadius, and distances below 1e-23 count as none.
struct Sphere {
  static constexpr float kMaxRadius = 1e19F;

  float center[3];
  float radius;
};

struct RayHit {
  ProxyHandle proxy;
  // Where the ray enters the box, or the part of its way after which a moving box touches it; 0
  // where it starts inside or on a face.
  float distance = 0;

  friend bool operator==(const RayHit&, const RayHit&) = default;
};

struct ProxySetOptions {
  // Makes Resolve return ascending pairs, whatever the backend.
  bool sorted_pairs = false;
  // Fills added() and removed(); the pairs are then sorted too.
  bool pair_events = false;
  // Delays the end of a pair, so that one that trembles does not begin and end in each frame: it
  // begins when the boxes overlap, and ends when they are more than this far apart on an axis, or
  // one is removed or no longer passes. The pairs of Resolve are exact all the same. What is
  // negative or NaN counts as 0.
  float event_margin = 0;
  // Runs the parts of the search among static proxies (executor.h). It is borrowed and must outlive
  // the set.
  Executor* executor = nullptr;
};

class ProxySet {
 public:
  explicit ProxySet(const ProxySetOptions& options = {});
  ~ProxySet();
  ProxySet(ProxySet&&) noexcept;
  ProxySet& operator=(ProxySet&&) noexcept;

  // Adds a proxy, which the next Resolve and the next query see. Cost: O(1) for a moving proxy. One
  // that rests gets into its tree at the next use: some µs, or less where many come close together.
  ProxyHandle Add(const Aabb& box, const ProxyOptions& options = {});
  // Adds boxes[k] as handles[k]. `options` has one entry per box or one for all. If memory runs
  // out, those added before are in the set and the other handles are null. REQUIRES: as many
  // handles as boxes.
  void AddMany(std::span<const Aabb> boxes, std::span<const ProxyOptions> options,
               std::span<ProxyHandle> handles);
  // Returns false for a handle without a proxy, as the calls below do.
  bool Remove(ProxyHandle handle);
  // If one of the handles has no proxy, it returns false and removes nothing.
  bool RemoveMany(std::span<const ProxyHandle> handles);

  // Cost: O(1). A static proxy may be moved too, at the cost of an Add. A box of the same bytes
  // changes nothing: an engine may send the boxes of all its objects in each step.
  bool Move(ProxyHandle handle, const Aabb& box);
  // Gives boxes[k] to handles[k]. If one of the handles has no proxy, it returns false and moves
  // nothing. REQUIRES: equal sizes.
  bool Move(std::span<const ProxyHandle> handles, std::span<const Aabb> boxes);
  bool SetFilter(ProxyHandle handle, const CollisionFilter& filter);
  bool SetUser(ProxyHandle handle, uint64_t user);
  // Makes a moving proxy static or a static one moving and awake, at the cost of an Add. Handle and
  // id stay. One that was added as static and moves is searched by the set itself, not by the broad
  // phase: what moves most of the time is better added as moving.
  bool SetStatic(ProxyHandle handle, bool is_static);
  // A sleeping proxy promises not to move: its pairs with others that rest are kept, and no search
  // begins at it. Another box wakes it. Pairs, events and queries are those of one that is awake. A
  // static proxy stays as it is. Cost: that of an Add; the next Resolve searches once among all
  // that rest.
  bool SetSleeping(ProxyHandle handle, bool is_sleeping);
  bool is_sleeping(ProxyHandle handle) const;

  // Subtracts `offset` from all coordinates, for a world whose origin follows the camera. Boxes
  // that overlap still do, so that no pair ends; boxes may begin to touch that are nearer than
  // coordinates are rounded. A box that the shift takes beyond the largest float becomes invalid,
  // and stays so until it is moved, as one that was invalid before. An offset that is not finite is
  // kInvalidArgument and changes nothing. Cost: O(proxies).
  Status ShiftOrigin(const float offset[3]);
  // Frees what former proxies held. Ids and handles of living ones stay; places at the end of
  // moving_boxes() that are free go. Cost: O(proxies), and the next use sorts all trees.
  // Ends the validity of all spans. If memory runs out, all proxies are as they were, and some of
  // what could be freed may have been.
  void Compact();

  // A snapshot is the whole state as flat bytes in the caller's memory, for a game that rolls back:
  // restored, the set gives the pairs, events, handles, query results and orders that it gave after
  // it was saved (pairs of a backend in its own order excepted: sort them, or let the backend build
  // anew in both cases). It takes snapshot_bytes() bytes, some 53 per place and 4 per proxy, and
  // with events 8 per pair and 4 per proxy that has come since the latest Resolve. Cost
  // (tests/bench/programs/proxy_ratios_bench.cc on AMD Zen 4, 10,000 proxies in 57 bytes each):
  // 0.05 ms to save, 0.06 ms to restore; no allocation where the set has had as many proxies.
  size_t snapshot_bytes() const;
  // kInvalidArgument if there is less room than that; what follows in `snapshot` is left alone.
  Status Save(std::span<std::byte> snapshot) const;
  // Takes what a set with the same options has saved at the beginning of `snapshot`. Spans end, and
  // handles made since the save are given out again. The set is as it was if the snapshot is
  // refused: kDataLoss if it is cut off or damaged, kInvalidArgument if it is of another version of
  // the library or of other options. Do not restore what others may have made: a checksum finds no
  // intent. If memory runs out, only another Restore or the end of the set may follow.
  Status Restore(std::span<const std::byte> snapshot);

  bool is_alive(ProxyHandle handle) const;
  // Returns null for a handle without a proxy. Valid until the next Add, Compact or Restore.
  const Aabb* box(ProxyHandle handle) const;
  std::optional<ProxyOptions> options(ProxyHandle handle) const;
  // Returns the proxy that has this id now, for example in a pair of Resolve, or null.
  ProxyHandle handle(uint32_t id) const;
  // Returns the number of living proxies.
  size_t moving_count() const;
  size_t static_count() const;

  // Returns the boxes for the broad phase, indexed by id, with invalid ones for proxies that it
  // need not search. The array grows at the end, and shrinks in Compact only. Valid until the next
  // change.
  std::span<const Aabb> moving_boxes() const;

  // To be called once per frame with the pairs that a broad phase has found in moving_boxes().
  // Returns those that pass their filters, followed by the pairs of moving and static proxies that
  // pass theirs, as ids with a < b. They are in the order of the searches, or ascending
  // (ProxySetOptions). Valid until the next Resolve, and as long as `moving_pairs` is. REQUIRES: no
  // change of the set since the broad phase took the boxes, SetFilter, SetStatic, SetSleeping,
  // ShiftOrigin, Compact and Restore among them.
  std::span<const OverlapPair> Resolve(std::span<const OverlapPair> moving_pairs);

  // Returns the pairs by which the latest Resolve differs from the one before it, ascending; none
  // without pair_events. If a proxy has been removed or the filters no longer pass, removed()
  // contains the pair too, with the handles that it was added with. Valid until the next Resolve.
  std::span<const ProxyPair> added() const;
  std::span<const ProxyPair> removed() const;

  // Queries see all proxies as they are now. A proxy is found when its filter and the query's pass.
  // Results are in an order that is the same on every machine: handles by ascending index, hits by
  // ascending distance and then by index. Boxes are closed. A point is a box without a size. What
  // is not finite, a box that is not valid where one is swept, and what is negative as a distance
  // or radius, is kInvalidArgument; the results then stay as they were. QueryBox finds nothing for
  // a box that is not valid.
  //
  // Each query comes twice. The first overwrites a vector; after a change it refits the trees
  // concerned first, O(changes), or O(their proxies) where these move. The const one writes to the
  // caller's array, and `count` says how many there are: where that is more than the array's size,
  // the array holds some of them. It needs PrepareQueries after each change, and is
  // kFailedPrecondition without; any number of threads may make const queries at the same time.

  void QueryBox(const Aabb& box, const CollisionFilter& filter, std::vector<ProxyHandle>& out);
  Status QueryBox(const Aabb& box, const CollisionFilter& filter, std::span<ProxyHandle> out,
                  size_t& count) const;
  Status QuerySphere(const Sphere& sphere, const CollisionFilter& filter,
                     std::vector<ProxyHandle>& out);
  Status QuerySphere(const Sphere& sphere, const CollisionFilter& filter,
                     std::span<ProxyHandle> out, size_t& count) const;
  // Finds all hits within max_distance.
  Status CastRay(const Ray& ray, const CollisionFilter& filter, std::vector<RayHit>& hits);
  Status CastRay(const Ray& ray, const CollisionFilter& filter, std::span<RayHit> hits,
                 size_t& count) const;
  // Finds all boxes that the moving box touches.
  Status SweepBox(const BoxSweep& sweep, const CollisionFilter& filter, std::vector<RayHit>& hits);
  Status SweepBox(const BoxSweep& sweep, const CollisionFilter& filter, std::span<RayHit> hits,
                  size_t& count) const;
  // Find the first of those hits; the proxy of `hit` is null if there is none.
  Status CastRayNearest(const Ray& ray, const CollisionFilter& filter, RayHit& hit);
  Status CastRayNearest(const Ray& ray, const CollisionFilter& filter, RayHit& hit) const;
  Status SweepBoxNearest(const BoxSweep& sweep, const CollisionFilter& filter, RayHit& hit);
  Status SweepBoxNearest(const BoxSweep& sweep, const CollisionFilter& filter, RayHit& hit) const;

  // Many queries in one call. hits[k] is the nearest of rays[k]; a ray that is refused is named and
  // leaves all hits as they were. REQUIRES: equal sizes.
  Status CastRays(std::span<const Ray> rays, const CollisionFilter& filter,
                  std::span<RayHit> hits) const;
  // The same for boxes on their way.
  Status SweepBoxes(std::span<const BoxSweep> sweeps, const CollisionFilter& filter,
                    std::span<RayHit> hits) const;
  // The proxies in boxes[k] are out[ends[k − 1]] to out[ends[k]]; `ends` counts on where `out` is
  // too small. REQUIRES: equal sizes of boxes and ends.
  Status QueryBoxes(std::span<const Aabb> boxes, const CollisionFilter& filter,
                    std::span<ProxyHandle> out, std::span<size_t> ends) const;
  // The same for spheres; one that is refused is named and leaves all results as they were.
  Status QuerySpheres(std::span<const Sphere> spheres, const CollisionFilter& filter,
                      std::span<ProxyHandle> out, std::span<size_t> ends) const;

  // Does the work of the first query after a change.
  void PrepareQueries();

  // Returns how often a tree has been refitted, which is what queries after changes, and the
  // search of what is not in moving_boxes(), cost beside themselves.
  uint64_t refit_count() const;
  size_t native_bytes() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sweepstake

#include "sweepstake/names/end.h"
