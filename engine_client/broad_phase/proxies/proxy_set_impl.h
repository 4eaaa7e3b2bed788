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

class ProxySet::Impl {
 public:
  explicit Impl(const ProxySetOptions& options) : options_(options) {
    if (!(options_.event_margin > 0)) options_.event_margin = 0;
  }

  ProxyKind& KindOf(uint32_t id) { return (id & kStaticProxyBit) != 0 ? resting_ : moving_; }
  const ProxyTable& TableOf(uint32_t id) const {
    return ((id & kStaticProxyBit) != 0 ? resting_ : moving_).table();
  }
  // Returns the row of the handle's proxy, or ProxyTable::kNoRow if there is no such proxy.
  uint32_t Find(ProxyHandle handle) const { return TableOf(handle.index).Find(handle); }
  bool Lives(ProxyHandle handle) const { return Find(handle) != ProxyTable::kNoRow; }
  bool AllLive(std::span<const ProxyHandle> handles) const {
    return std::all_of(handles.begin(), handles.end(),
                       [&](ProxyHandle handle) { return Lives(handle); });
  }
  // Calls change(kind, row) if the proxy exists; returns whether it does.
  template <typename Fn>
  bool Change(ProxyHandle handle, const Fn& change) {
    const uint32_t row = Find(handle);
    if (row == ProxyTable::kNoRow) return false;
    change(KindOf(handle.index), row);
    return true;
  }

  ProxyHandle Add(const Aabb& box, const ProxyOptions& options);
  void Remove(ProxyKind& kind, uint32_t row);
  void Move(ProxyKind& kind, uint32_t row, const Aabb& box);
  bool PrepareMove(std::span<const ProxyHandle> handles, std::span<const Aabb> boxes);
  void SetFilter(ProxyKind& kind, uint32_t row, const CollisionFilter& filter);
  void SetStatic(ProxyKind& kind, uint32_t row, bool is_static);
  void SetSleeping(ProxyKind& kind, uint32_t row, bool is_sleeping);

  void FreeUnused();
  void ShrinkRows();
  std::span<const OverlapPair> Resolve(std::span<const OverlapPair> moving_pairs,
                                       uint64_t max_pairs);
  void SkipResolve() {
    events_.Clear();
    pairs_exceeded_ = true;
  }
  bool pairs_exceeded() const { return pairs_exceeded_; }
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

  ProxyKind moving_{0};
  ProxyKind resting_{kStaticProxyBit};
  PairEvents events_{moving_.table(), resting_.table()};

 private:
  bool wants_sorted() const { return options_.sorted_pairs || options_.pair_events; }
  template <typename Self, typename Archive>
  static void Visit(Self& self, Archive& archive);
  void AppendMoving(std::span<const OverlapPair> moving_pairs);
  ProxySetOptions options_;
  FilterGroups groups_;
  KdOrder splitter_;  // sorts one tree at a time
  PopulationJoins joins_{moving_, resting_, options_.executor};
  PairBuffer pairs_;  // the pairs of the latest Resolve
  PairBuffer next_;   // the pairs of the Resolve in progress
  // The largest number of pairs since the latest FreeUnused, and the number of Resolves since then.
  size_t peak_pair_count_ = 0;
  uint32_t resolve_count_ = 0;
  bool pairs_exceeded_ = false;   // by the latest Resolve
  bool is_oversized_ = false;     // whether a FreeUnused has found much unused memory
  bool may_shrink_rows_ = false;  // whether no change has followed the latest FreeUnused
  PairSorter sorter_;
};

}  // namespace sweepstake
