// Finds which pairs have begun and which have ended between two frames.
//
// Not thread-safe. Owns its memory. Memory: 16 bytes per event. Errors: std::bad_alloc from
// Compare, which then leaves no events.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/host/hook_points.h"
#include "engine_client/broad_phase/proxies/proxy_table.h"
#include "sweepstake/pair_buffer.h"
#include "sweepstake/proxy_set.h"

namespace sweepstake {

// Returns a number that orders pairs by a, then by b.
constexpr uint64_t PairKey(const OverlapPair& pair) { return uint64_t{pair.a} << 32 | pair.b; }

class PairEvents {
 public:
  // Compares `before`, the pairs at the last MarkSeen of the tables, with `now`, the present pairs.
  // Both are sorted by PairKey. If an id of a pair has passed to a new proxy, the old pair counts
  // as ended and the new one as begun. Cost: O(pairs).
  void Compare(std::span<const OverlapPair> before, std::span<const OverlapPair> now,
               const ProxyTable& moving, const ProxyTable& resting);

  void Clear() {
    added_.clear();
    removed_.clear();
  }

  // Appends to `out` the pairs of `now` and the pairs of `before` that have not ended. A pair goes
  // on if its ids still belong to the same proxies, these two may form a pair, and their boxes are
  // at most `margin` apart on each axis. All lists are sorted by PairKey. Cost: O(pairs).
  static void Hold(std::span<const OverlapPair> before, std::span<const OverlapPair> now,
                   float margin, const ProxyTable& moving, const ProxyTable& resting,
                   PairBuffer& out);

  std::span<const ProxyPair> added() const { return added_; }
  std::span<const ProxyPair> removed() const { return removed_; }
  // Passes the fields of a snapshot to `archive` (snapshot.h).
  template <typename Self, typename Archive>
  static void Visit(Self& self, Archive& archive) {
    archive.Array(self.added_);
    archive.Array(self.removed_);
  }
  // Frees unused capacity.
  void Compact() {
    added_.shrink_to_fit();
    removed_.shrink_to_fit();
  }
  size_t native_bytes() const {
    return (added_.capacity() + removed_.capacity()) * sizeof(ProxyPair);
  }

 private:
  HookedVector<ProxyPair> added_;
  HookedVector<ProxyPair> removed_;
};

}  // namespace sweepstake
