// The implementation of ProxySet (proxy_set.h): the proxies of both kinds, the groups of their
// filters, the search for pairs that the broad phase does not find, and the latest pairs.
//
// Not thread-safe, like ProxySet. Owns everything except the executor.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/kd/kd_order.h"
#include "engine_client/broad_phase/proxies/pair_events.h"
#include "engine_client/broad_phase/proxies/population_joins.h"
#include "engine_client/broad_phase/proxies/populations.h"
#include "engine_client/broad_phase/proxies/proxy_kind.h"
#include "sweepstake/pair_buffer.h"
#include "sweepstake/pair_sorter.h"
#include "sweepstake/proxy_set.h"

namespace sweepstake {

constexpr uint32_t PlaceOf(uint32_t id) { return id & ~kStaticProxyBit; }

class ProxySet::Impl {
 public:
  explicit Impl(const ProxySetOptions& options)
      : moving_(0, options.pair_events),
        resting_(kStaticProxyBit, options.pair_events),
        options_(options) {
    if (!(options_.event_margin > 0)) options_.event_margin = 0;
  }

  ProxyKind& KindOf(uint32_t id) { return (id & kStaticProxyBit) != 0 ? resting_ : moving_; }
  const ProxyKind& KindOf(uint32_t id) const {
    return (id & kStaticProxyBit) != 0 ? resting_ : moving_;
  }
  // Returns the kind of the handle's proxy, or null if there is no such proxy.
  const ProxyKind* Find(ProxyHandle handle) const {
    const ProxyKind& kind = KindOf(handle.index);
    return kind.table().Holds(PlaceOf(handle.index), handle.generation) ? &kind : nullptr;
  }
  bool AllLive(std::span<const ProxyHandle> handles) const {
    return std::all_of(handles.begin(), handles.end(),
                       [&](ProxyHandle handle) { return Find(handle) != nullptr; });
  }
  // Calls change(kind, place) if the proxy exists; returns whether it does.
  template <typename Fn>
  bool Change(ProxyHandle handle, const Fn& change) {
    if (Find(handle) == nullptr) return false;
    change(KindOf(handle.index), PlaceOf(handle.index));
    return true;
  }

  ProxyHandle Add(const Aabb& box, const ProxyOptions& options);
  void Remove(ProxyKind& kind, uint32_t place);
  void Move(ProxyKind& kind, uint32_t place, const Aabb& box);
  void EnsureRoomToWake(std::span<const ProxyHandle> handles, std::span<const Aabb> boxes);
  void SetFilter(ProxyKind& kind, uint32_t place, const CollisionFilter& filter);
  void SetStatic(ProxyKind& kind, uint32_t place, bool is_static);
  void SetSleeping(ProxyKind& kind, uint32_t place, bool is_sleeping);
  void Compact();

  std::span<const OverlapPair> Resolve(std::span<const OverlapPair> moving_pairs);
  void RefreshTrees() {
    moving_.RefreshTrees(splitter_);
    resting_.RefreshTrees(splitter_);
  }
  // Calls question(queries) if the shape is valid and no tree is out of date; otherwise returns an
  // error. (proxy_set_queries.cc)
  template <typename Shape, typename Question>
  Status Ask(const Shape& shape, const Question& question) const;
  // Writes the nearest hit of each shape to `hits`. `name` is the word for a shape in error
  // messages.
  template <typename Shape>
  Status FindNearestHits(const char* name, std::span<const Shape> shapes,
                         const CollisionFilter& filter, std::span<RayHit> hits) const;
  // Calls search(queries, shape, found) for each shape. The results of all shapes are consecutive
  // in `out`.
  template <typename Shape, typename Search>
  Status FindMany(std::span<const Shape> shapes, std::span<ProxyHandle> out, std::span<size_t> ends,
                  const Search& search) const;
  // Refreshes the trees, then does the same as Ask.
  template <typename Shape, typename Question>
  Status RefreshAndAsk(const Shape& shape, const Question& question);
  // Snapshots (proxy_set_snapshot.cc).
  size_t snapshot_bytes() const;
  Status Save(std::span<std::byte> snapshot) const;
  Status Restore(std::span<const std::byte> snapshot);
  size_t native_bytes() const;

  ProxyKind moving_;
  ProxyKind resting_;
  PairEvents events_;

 private:
  bool wants_sorted() const { return options_.sorted_pairs || options_.pair_events; }
  template <typename Self, typename Archive>
  static void Visit(Self& self, Archive& archive);
  void FindEvents();
  void AppendMoving(std::span<const OverlapPair> moving_pairs);

  ProxySetOptions options_;
  FilterGroups groups_;
  KdOrder splitter_;  // sorts one tree at a time
  PopulationJoins joins_{moving_, resting_, options_.executor};
  PairBuffer pairs_;  // the pairs of the latest Resolve
  PairBuffer next_;   // the pairs of the Resolve in progress
  // The pairs that have begun and not ended, after the latest Resolve (begun_) and in the Resolve
  // in progress (next_begun_). Used only with the option event_margin.
  PairBuffer begun_;
  PairBuffer next_begun_;
  PairSorter sorter_;
};

}  // namespace sweepstake
