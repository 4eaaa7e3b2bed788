// The proxies of one kind, moving or static, and the events of their pairs.
//
// A proxy has a place that does not change while it lives. A place is used again after its proxy
// was removed; its generation counts adds and removes and so distinguishes the owners.
//
// Not thread-safe. Owns its memory. Cost: O(1) per call unless its comment says otherwise. Memory:
// 56 bytes per place. Errors: std::bad_alloc from Add, which then changes nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "engine_client/broad_phase/host/hook_points.h"
#include "sweepstake/proxy_set.h"

namespace sweepstake {

// Returns a number that orders pairs by a, then by b.
constexpr uint64_t PairKey(const OverlapPair& pair) { return uint64_t{pair.a} << 32 | pair.b; }

class ProxyTable {
 public:
  static constexpr size_t kMaxPlaces = 0x7fffffff;

  // Returns the place of the new proxy: the place freed last, or else a new one at the end.
  uint32_t Add(const Aabb& box, const CollisionFilter& filter, uint64_t user);

  bool Holds(uint32_t place, uint32_t generation) const {
    return place < generations_.size() && generations_[place] == generation && IsOdd(generation);
  }

  // REQUIRES: `place` holds a proxy.
  void Remove(uint32_t place);
  // A box of the same bytes changes nothing. REQUIRES: `place` holds a proxy.
  void SetBox(uint32_t place, const Aabb& box) {
    if (std::memcmp(&boxes_[place], &box, sizeof box) == 0) return;
    boxes_[place] = box;
    changed_ = true;
  }
  // REQUIRES: `place` holds a proxy.
  void SetFilter(uint32_t place, const CollisionFilter& filter);
  // REQUIRES: `place` holds a proxy.
  void SetUser(uint32_t place, uint64_t user) { users_[place] = user; }
  // REQUIRES: `place` holds a proxy.
  uint64_t user(uint32_t place) const { return users_[place]; }
  // Returns 0 if the place is free or does not exist.
  uint32_t generation(uint32_t place) const {
    return place < generations_.size() && IsOdd(generations_[place]) ? generations_[place] : 0;
  }

  // These are indexed by place; a free place has an invalid box.
  std::span<const Aabb> boxes() const { return boxes_; }
  std::span<const CollisionFilter> filters() const { return filters_; }
  size_t count() const { return boxes_.size() - free_.size(); }
  // Returns whether every proxy has the default filter.
  bool all_pass() const { return filtered_count_ == 0; }

  // Returns whether a box has changed since MarkUnchanged.
  bool changed() const { return changed_; }
  void MarkUnchanged() { changed_ = false; }

  // Returns whether a place has an owner that has come since the last MarkSeen.
  bool any_new_owner() const { return !new_owners_.empty(); }
  // Returns whether the place has another owner than at the last MarkSeen. REQUIRES: the place was
  // taken then and is taken now.
  bool HasNewOwner(uint32_t place) const { return seen_[place] != generations_[place]; }
  uint32_t seen_generation(uint32_t place) const { return seen_[place]; }
  // Takes the present owners as seen. Cost: O(places with new owners).
  void MarkSeen();

  size_t native_bytes() const;

 private:
  // A generation is odd while the place is taken.
  static bool IsOdd(uint32_t generation) { return (generation & 1) != 0; }

  void EnsureRoomForOne();
  uint32_t TakePlace();

  HookedVector<Aabb> boxes_;
  HookedVector<CollisionFilter> filters_;
  HookedVector<uint64_t> users_;
  HookedVector<uint32_t> generations_;
  HookedVector<uint32_t> seen_;  // the generations at the last MarkSeen
  // The freed places; there is room for every place, so that Remove does not allocate.
  HookedVector<uint32_t> free_;
  // The places with owners that have come since the last MarkSeen, each once.
  HookedVector<uint32_t> new_owners_;
  size_t filtered_count_ = 0;
  bool changed_ = false;
};

// Finds which pairs are new and which are gone, given the ascending pairs of one frame and of the
// next. Cost: O(pairs). Errors: std::bad_alloc from Compare; the events are then incomplete.
class PairEvents {
 public:
  // `before` are pairs of the proxies at the last MarkSeen of the tables, `now` of those they hold;
  // both ascend. A pair whose ids have stayed but whose owners have changed is both gone and new.
  void Compare(std::span<const OverlapPair> before, std::span<const OverlapPair> now,
               const ProxyTable& moving, const ProxyTable& resting);

  std::span<const ProxyPair> added() const { return added_; }
  std::span<const ProxyPair> removed() const { return removed_; }
  size_t native_bytes() const {
    return (added_.capacity() + removed_.capacity()) * sizeof(ProxyPair);
  }

 private:
  HookedVector<ProxyPair> added_;
  HookedVector<ProxyPair> removed_;
};

}  // namespace sweepstake
