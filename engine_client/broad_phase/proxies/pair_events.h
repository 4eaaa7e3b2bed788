// Finds which pairs have begun and which have ended between two frames.
//
// Not thread-safe. Borrows the tables. Owns its memory. Memory: 32 bytes per pair and 16 per event.
// Errors: std::bad_alloc from Update, which then leaves no events and the begun pairs as they were,
// and from FreeUnused, which then changes nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/host/hook_points.h"
#include "engine_client/broad_phase/proxies/proxy_table.h"
#include "sweepstake/proxy_set.h"

namespace sweepstake {

// Returns a number that orders pairs by a, then by b.
constexpr uint64_t PairKey(const OverlapPair& pair) { return uint64_t{pair.a} << 32 | pair.b; }
constexpr uint64_t PairKey(const ProxyPair& pair) {
  return PairKey(OverlapPair{pair.a.index, pair.b.index});
}

class PairEvents {
 public:
  PairEvents(const ProxyTable& moving, const ProxyTable& resting)
      : moving_(moving), resting_(resting) {}

  // Compares the pairs that have begun and not ended with `now`, the present pairs as ids in
  // ascending order. If an id of a pair has passed to a new proxy, the old pair has ended and the
  // new one begins. A pair that is not in `now` ends unless all of this holds: both proxies live,
  // they may form a pair, and their boxes are at most `margin` apart on each axis. A margin of 0
  // ends it anyway. Cost: O(pairs).
  void Update(std::span<const OverlapPair> now, float margin);
  void Clear() {
    added_.clear();
    removed_.clear();
  }

  // The pairs that began and ended in the latest Update, ascending.
  std::span<const ProxyPair> added() const { return added_; }
  std::span<const ProxyPair> removed() const { return removed_; }

  // Frees unused capacity.
  void FreeUnused();
  // Passes the fields of a snapshot to `archive` (snapshot.h).
  template <typename Self, typename Archive>
  static void Visit(Self& self, Archive& archive) {
    archive.Array(self.added_);
    archive.Array(self.removed_);
    archive.Array(self.begun_);
  }
  size_t native_bytes() const {
    return (added_.capacity() + removed_.capacity() + begun_.capacity() + next_begun_.capacity()) *
           sizeof(ProxyPair);
  }

 private:
  const ProxyTable& TableOf(uint32_t id) const {
    return (id & kStaticProxyBit) != 0 ? resting_ : moving_;
  }
  bool Lives(ProxyHandle handle) const {
    return TableOf(handle.index).Find(handle) != ProxyTable::kNoRow;
  }
  ProxyPair HandlesOf(const OverlapPair& pair) const;
  bool GoesOn(const ProxyPair& pair, float margin) const;

  const ProxyTable& moving_;
  const ProxyTable& resting_;
  HookedVector<ProxyPair> added_;
  HookedVector<ProxyPair> removed_;
  HookedVector<ProxyPair> begun_;       // the pairs that have begun and not ended, ascending
  HookedVector<ProxyPair> next_begun_;  // those of the Update in progress
};

}  // namespace sweepstake
