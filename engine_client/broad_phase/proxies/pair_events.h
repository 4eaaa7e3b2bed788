// Which pairs are new and which are gone, from one frame's ascending pairs to the next's.
//
// Not thread-safe. Owns its memory, kept between frames. Cost: O(pairs), some 2 ns per pair.
// Errors: std::bad_alloc from Compare; the events are then incomplete.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine_client/broad_phase/proxies/proxy_table.h"
#include "sweepstake/proxy_set.h"

namespace sweepstake {

class PairEvents {
 public:
  // Both ascending; `before` are pairs of the proxies at the tables' last MarkSeen, `now` of those
  // they hold. A pair of one id and another owner is gone and new at once.
  void Compare(std::span<const OverlapPair> before, std::span<const OverlapPair> now,
               const ProxyTable& moving, const ProxyTable& resting);

  std::span<const ProxyPair> added() const { return added_; }
  std::span<const ProxyPair> removed() const { return removed_; }
  size_t native_bytes() const {
    return (added_.capacity() + removed_.capacity()) * sizeof(ProxyPair);
  }

 private:
  std::vector<ProxyPair> added_;
  std::vector<ProxyPair> removed_;
};

}  // namespace sweepstake
