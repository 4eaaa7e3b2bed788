// Adds to a broad phase what an engine needs around it: objects with stable handles, collision
// filters, static objects, pair events and queries. It works with any backend, and with an
// AdaptiveBroadPhase that switches its arms:
//
//   ProxySet proxies({.pair_events = true});
//   const ProxyHandle player = proxies.Add(box, {.filter = {.category = 2, .mask = 5}});
//   ... each frame ...
//   proxies.Move(player, box);
//   const auto pairs = adaptive.FindPairs(proxies);
//   for (const ProxyPair& pair : proxies.added()) ...
//
// The living moving proxies are in one dense array, which is the input of the broad phase. A
// removed proxy leaves an invalid box to the next new one. If more than 1 in 32 boxes is invalid,
// the last boxes take these places. For a broad phase, adding and removing are thus ordinary
// updates, and removed proxies cost next to nothing. Proxies that the broad phase need not search
// are not in the array but in trees of the set, in which other proxies are searched for. There are
// three kinds:
// - static proxies, which are never paired with one another and cost nothing while they do not
//   change;
// - sleeping proxies, whose pairs with other sleeping and static ones are kept;
// - moving proxies that ignore their own kind: their category is not in their own mask, as debris
//   that collides with everything but debris. A pile of them costs no more than the same proxies
//   far apart. Up to seven such groups of filters are possible; pairs of further groups are
//   filtered after the search.
//
// Pairs, events and queries never depend on where a proxy is kept.
//
// Thread safety: one thread at a time, but any number of threads may make const calls at the same
// time between changes. Ownership: the set owns the memory of its spans. Units: world units of the
// caller. An invalid box (aabb.h) is accepted: it overlaps nothing and no query finds it, until it
// is moved.
//
// Memory:
// - 53 bytes per proxy, with room for a power of two of proxies
// - 4 bytes per id, in pages of 1,024 ids. An id is the lowest free one; a page without a proxy is
//   freed
// - 32 more per proxy in a tree that was searched, or 36 if the tree has more than 60,000 proxies;
//   up to four times that after many removals. The first query searches all trees
// - 36 per proxy of the largest such tree, to sort it
// - 16 bytes per pair, 24 if pairs are sorted, 56 with events, and 8 per kept pair
// Every 256th Resolve frees the memory that the latest 256 have not needed. The next Add or Remove
// frees that of the proxies: it copies them if at least half of the memory is unused.
//
// Cost: measured by tests/bench/programs/proxies_bench.cc on one thread of AMD Zen 5, with 10,000
// moving boxes of suite-b and 14,500 pairs. The measurement is without sleeping proxies and without
// groups that ignore their own kind. Move takes 5 ns. Resolve takes 13 µs with filters and nothing
// without, 70 µs with sorted pairs and 120 µs with events. With 100,000 static boxes and their
// 29,400 pairs it takes 0.28 ms, and 0.19 ms on two threads. After the number of proxies has
// shrunk, Resolve takes 2 ns more per pair, to convert indices to ids. A query among all of these
// takes 0.33 µs for a box that finds five, 0.33 µs for the first of a ray's twelve hits and 1.1 µs
// for all of them. The first query after a change takes 20 µs more for the moving proxies.
//
// Resting proxies cost a frame only for their changes (tests/bench/programs/proxy_ratios_bench.cc,
// AMD EPYC). Replacing one static proxy takes 12 µs among 20,000, and 33 µs among 2,000,000. Adding
// 18,000 nearby ones at once, such as a tile of a world, takes 5 ms. If the added ones are spread
// over the world, or if half as many as the tree holds have been added one by one, the tree is
// sorted again. That takes 0.25 s for 2,000,000.
//
// Errors: a handle that is null, stale (its proxy was removed) or unknown to this set yields false,
// null or an empty result, never another proxy, and changes nothing. If memory or the 2^31 − 1 ids
// of a kind are exhausted, a call ends as described at OutOfMemory() (hooks.h). The set is
// then unchanged unless the call's comment says otherwise.
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

// A handle identifies a proxy. `index` is the proxy's id in pairs while it lives: a number, and
// kStaticProxyBit if it was added as static. A new proxy gets the lowest free number, so that ids
// may index an array of the caller. `generation` counts the proxies added as moving, or those added
// as static. After 2^32 − 1 it begins at 1 again: a stale handle could identify another proxy only
// if that one got the same id exactly 2^32 − 1 additions later. The null handle is all zero and
// belongs to no proxy.
struct ProxyHandle {
  uint32_t index = 0;
  uint32_t generation = 0;

  bool is_null() const { return generation == 0; }
  // clang-tidy reports a comparison with 0 that the compiler generates.
  // NOLINTNEXTLINE(modernize-use-nullptr)
  friend auto operator<=>(const ProxyHandle&, const ProxyHandle&) = default;
};
static_assert(sizeof(ProxyHandle) == 8);

// An id has this bit if and only if its proxy was added as static.
inline constexpr uint32_t kStaticProxyBit = 0x80000000U;

// The kinds that a proxy belongs to (category) and collides with (mask), as bit sets. The default
// passes every filter that has a category and a mask.
struct CollisionFilter {
  uint32_t category = ~0U;
  uint32_t mask = ~0U;

  friend bool operator==(const CollisionFilter&, const CollisionFilter&) = default;
};

// Returns whether the category of each filter is in the mask of the other.
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

// A box swept along `translation`, and all points it covers on the way. The box must be valid, its
// translation finite.
struct BoxSweep {
  Aabb box;
  float translation[3];
};

// The points up to `radius` from the center. Distances are compared as squares in single precision:
// the radius must be from 0 to kMaxRadius, and distances below 1e-23 count as 0.
struct Sphere {
  static constexpr float kMaxRadius = 1e19F;

  float center[3];
  float radius;
};

struct RayHit {
  ProxyHandle proxy;
  // The distance at which the ray enters the box, in multiples of the direction's length. For a
  // sweep: the fraction of the translation after which the boxes touch. 0 if it starts inside or on
  // a face.
  float distance = 0;

  friend bool operator==(const RayHit&, const RayHit&) = default;
};

struct ProxySetOptions {
  // Makes Resolve return ascending pairs, whatever the backend.
  bool sorted_pairs = false;
  // Fills added() and removed(); the pairs are then sorted too.
  bool pair_events = false;
  // Delays the end of a pair, so that a pair whose boxes touch intermittently does not begin and
  // end in every frame. A pair begins when its boxes overlap. It ends when they are more than this
  // far apart on an axis, when one is removed or when the filters no longer pass. The pairs of
  // Resolve stay exact. A negative value or NaN counts as 0.
  float event_margin = 0;
  // Runs the parts of the search among static proxies (executor.h). Borrowed; must outlive the set.
  Executor* executor = nullptr;
};

class AdaptiveBroadPhase;

class ProxySet {
 public:
  explicit ProxySet(const ProxySetOptions& options = {});
  ~ProxySet();
  ProxySet(ProxySet&&) noexcept;
  ProxySet& operator=(ProxySet&&) noexcept;

  // Adds a proxy, which the next Resolve and the next query see. Cost: O(1) for a moving proxy. A
  // resting one enters its tree at the next use: a few µs, or less if many are added close
  // together.
  ProxyHandle Add(const Aabb& box, const ProxyOptions& options = {});
  // Adds boxes[k] as handles[k]. `options` has one entry per box or one for all. If memory runs
  // out, the proxies added so far stay in the set and the other handles are null. REQUIRES: as many
  // handles as boxes.
  void AddMany(std::span<const Aabb> boxes, std::span<const ProxyOptions> options,
               std::span<ProxyHandle> handles);
  // Removes the proxy. Returns false if the handle has no proxy, as all functions below with a bool
  // result do.
  bool Remove(ProxyHandle handle);
  // If one of the handles has no proxy, returns false and removes nothing.
  bool RemoveMany(std::span<const ProxyHandle> handles);

  // Sets the box. Cost: O(1) for a moving proxy; as much as an Add for a static one. A bitwise
  // equal box changes nothing, so an engine may send the boxes of all its objects in each step.
  bool Move(ProxyHandle handle, const Aabb& box);
  // Gives boxes[k] to handles[k]. If one of the handles has no proxy, returns false and moves
  // nothing. REQUIRES: equal sizes.
  bool Move(std::span<const ProxyHandle> handles, std::span<const Aabb> boxes);
  bool SetFilter(ProxyHandle handle, const CollisionFilter& filter);
  bool SetUser(ProxyHandle handle, uint64_t user);
  // Makes a moving proxy static, or a static one moving and awake. Cost: as an Add. Handle and id
  // stay the same. A proxy that was added as static and is moving now is searched by the set
  // itself, not by the broad phase, which costs more. So add proxies that move most of the time as
  // moving.
  bool SetStatic(ProxyHandle handle, bool is_static);
  // Marks a proxy that will not move. Its pairs with other resting (static or sleeping) proxies are
  // kept, and no search starts from it. Setting a different box wakes it. Pairs, events and queries
  // are the same as without the mark. Does nothing for a static proxy. Cost: as an Add; the next
  // Resolve searches once among all resting proxies.
  bool SetSleeping(ProxyHandle handle, bool is_sleeping);
  bool is_sleeping(ProxyHandle handle) const;

  // Subtracts `offset` from all coordinates, for a world whose origin follows the camera. Boxes
  // that overlap still do, so no pair ends. Boxes whose gap is below the rounding of coordinates
  // may begin to touch. A box that the shift takes beyond the largest float becomes invalid until
  // it is moved; an invalid box stays invalid. An offset that is not finite is kInvalidArgument and
  // changes nothing. Cost: O(proxies).
  Status ShiftOrigin(const float offset[3]);

  // A snapshot is the whole state as flat bytes in the caller's memory, for a game that rolls back.
  // A restored set gives the same pairs, events, handles, query results and orders as after the
  // save. The order of unsorted pairs also depends on the backend: sort them, or rebuild the
  // backend in both cases.
  //
  // A snapshot takes snapshot_bytes() bytes: about 57 per living proxy; with events also 16 per
  // pair and per event. Cost
  // (tests/bench/programs/proxy_ratios_bench.cc on AMD Zen 4, 10,000 proxies in 57 bytes each):
  // 0.05 ms to save, 0.09 ms to restore. Nothing is allocated if the set has held as many proxies
  // since the latest 256 Resolves.
  size_t snapshot_bytes() const;
  // Returns kInvalidArgument if `snapshot` is smaller than snapshot_bytes(). Bytes after the
  // snapshot stay unchanged.
  Status Save(std::span<std::byte> snapshot) const;
  // Restores a snapshot that a set with the same options has saved at the beginning of `snapshot`.
  // Invalidates spans; handles made since the save are given out again. If the snapshot is refused,
  // the set is unchanged. The error is kDataLoss if it is cut off or damaged, kInvalidArgument if
  // it is of another version of the library or of other options. Do not restore untrusted
  // snapshots: the checksum does not detect deliberate changes. If memory runs out, the set may
  // only be restored again or destroyed.
  Status Restore(std::span<const std::byte> snapshot);

  bool is_alive(ProxyHandle handle) const;
  // Returns null if the handle has no proxy. Valid until the next change.
  const Aabb* box(ProxyHandle handle) const;
  std::optional<ProxyOptions> options(ProxyHandle handle) const;
  // Returns the proxy that has this id now, for example in a pair of Resolve, or null.
  ProxyHandle handle(uint32_t id) const;
  // Returns the number of living proxies.
  size_t moving_count() const;
  size_t static_count() const;

  // Returns the boxes of the proxies that the broad phase must search. An index is not an id;
  // Resolve converts it. Valid until the next change.
  std::span<const Aabb> moving_boxes() const;

  // Call it once per frame with the pairs that a broad phase has found in moving_boxes(), as
  // indices of that array. Returns the pairs that pass their filters, followed by the passing pairs
  // of moving and static proxies, as ids with a < b. They are in the order of the searches, or
  // ascending (ProxySetOptions). Valid until the next Resolve, and only while `moving_pairs` is.
  // REQUIRES: no change of the set since the broad phase received the boxes. SetFilter, SetStatic,
  // SetSleeping, ShiftOrigin and Restore count as changes.
  //
  // `max_pairs` is the maximum number of pairs; 0: no limit. `moving_pairs` and the pairs that the
  // set finds itself count, before the filters. With more pairs the search ends early, as that of
  // BroadPhaseOptions::max_pairs. There are then no pairs and no events, and pairs_exceeded() is
  // true. The next successful Resolve reports all changes since the latest successful one, so that
  // no pair ends in between. Skip Resolve and the events after a search that exceeded its own
  // limit, or call AdaptiveBroadPhase::FindPairs(ProxySet&), which does all this.
  std::span<const OverlapPair> Resolve(std::span<const OverlapPair> moving_pairs,
                                       uint64_t max_pairs = 0);
  // Returns whether the latest Resolve ended because of max_pairs.
  bool pairs_exceeded() const;

  // Returns the pairs that began and ended between the latest two successful Resolves, ascending;
  // empty without pair_events. If a proxy was removed or the filters no longer pass, removed()
  // contains the pair too, with the handles it began with. Valid until the next Resolve.
  std::span<const ProxyPair> added() const;
  std::span<const ProxyPair> removed() const;

  // Queries use the current state of all proxies. A proxy is found if its filter and the query's
  // filter pass. The order of results is the same on every machine: handles by ascending index,
  // hits by ascending distance and then by index. Boxes are closed. A box of size zero queries a
  // point. kInvalidArgument, with results unchanged: a value that is not finite, an invalid box to
  // sweep, a negative distance or radius. QueryBox finds nothing for an invalid box.
  //
  // Each query has two forms. The first overwrites a vector. After a change it first refits the
  // affected trees: O(changes), or O(proxies of the tree) if these move. The const form writes to
  // the caller's array, and sets `count` to the number of results; if that exceeds the array's
  // size, the array holds some of them. It needs PrepareQueries after each change, and returns
  // kFailedPrecondition without it. Any number of threads may make const queries at the same time.

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
  // Find the nearest hit within the range; the handle in `hit` is null if nothing is hit.
  Status CastRayNearest(const Ray& ray, const CollisionFilter& filter, RayHit& hit);
  Status CastRayNearest(const Ray& ray, const CollisionFilter& filter, RayHit& hit) const;
  Status SweepBoxNearest(const BoxSweep& sweep, const CollisionFilter& filter, RayHit& hit);
  Status SweepBoxNearest(const BoxSweep& sweep, const CollisionFilter& filter, RayHit& hit) const;

  // Several queries in one call. hits[k] is the nearest hit of rays[k]. If a ray is refused, the
  // message names it and no hit changes. REQUIRES: equal sizes.
  Status CastRays(std::span<const Ray> rays, const CollisionFilter& filter,
                  std::span<RayHit> hits) const;
  // Like CastRays, but for swept boxes.
  Status SweepBoxes(std::span<const BoxSweep> sweeps, const CollisionFilter& filter,
                    std::span<RayHit> hits) const;
  // The proxies that overlap boxes[k] are in `out` from ends[k − 1] (0 for the first box) to
  // ends[k]. If `out` is too small, `ends` still counts all results. REQUIRES: equal sizes of boxes
  // and ends.
  Status QueryBoxes(std::span<const Aabb> boxes, const CollisionFilter& filter,
                    std::span<ProxyHandle> out, std::span<size_t> ends) const;
  // Like QueryBoxes, but for spheres. If a sphere is refused, the message names it and no result
  // changes.
  Status QuerySpheres(std::span<const Sphere> spheres, const CollisionFilter& filter,
                      std::span<ProxyHandle> out, std::span<size_t> ends) const;

  // Updates the trees after changes, so that const queries may follow. Without it, the first
  // non-const query after a change does the same work.
  void PrepareQueries();

  // Returns how often a tree was refitted (its bounds were updated after changes). Queries after
  // changes, and searches for proxies outside moving_boxes(), cost a refit in addition to the
  // search.
  uint64_t refit_count() const;
  size_t native_bytes() const;
  // Frees the memory that was not needed since the previous FreeUnused, which every 256th Resolve
  // calls too. Only a set that is queried without Resolve needs it. Counts as a change, and
  // invalidates what is valid until the next Resolve.
  void FreeUnused();

 private:
  friend class AdaptiveBroadPhase;  // calls SkipResolve
  // Replaces the Resolve after a search that exceeded max_pairs: there are no events.
  void SkipResolve();

  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sweepstake

#include "sweepstake/names/end.h"
