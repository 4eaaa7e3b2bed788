// Holds the proxies of one kind: all proxies added as moving, or all proxies added as static.
//
// Each proxy has a place, an index that stays the same until the proxy is removed. The place may
// then pass to another proxy, its new owner. A place's generation counts adds and removes, and so
// distinguishes its owners.
//
// Not thread-safe. Owns its memory. Cost: O(1) per call unless its comment says otherwise. Memory:
// 53 bytes per place, 4 more if owners are recorded, and 24 more after HideOthers. Errors:
// std::bad_alloc from Add and HideOthers, which then change nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/common/box_record.h"
#include "engine_client/broad_phase/host/hook_points.h"
#include "sweepstake/proxy_set.h"

namespace sweepstake {

class ProxyTable {
 public:
  static constexpr size_t kMaxPlaces = 0x7fffffff;

  // With `notes_owners` the table records which places have got new owners since the last MarkSeen.
  // Without it, the functions about new owners must not be called.
  explicit ProxyTable(bool notes_owners) : notes_owners_(notes_owners) {}

  // Adds a proxy and returns its place: the place freed last, or else a new one at the end.
  uint32_t Add(const Aabb& box, const CollisionFilter& filter, uint64_t user);

  bool Holds(uint32_t place, uint32_t generation) const {
    return place < generations_.size() && generations_[place] == generation && IsOdd(generation);
  }

  // Calls with a place require that a proxy is there, unless their comment says otherwise.

  void Remove(uint32_t place);
  void SetBox(uint32_t place, const Aabb& box) {
    boxes_[place] = box;
    if (hides_others_ && populations_[place] == 0) shown_[place] = box;
  }
  void SetFilter(uint32_t place, const CollisionFilter& filter);
  void SetUser(uint32_t place, uint64_t user) { users_[place] = user; }
  uint64_t user(uint32_t place) const { return users_[place]; }
  // Returns the place's generation, or 0 if the place is free or does not exist.
  uint32_t generation(uint32_t place) const {
    return place < generations_.size() && IsOdd(generations_[place]) ? generations_[place] : 0;
  }

  // A new proxy is in population 0.
  uint8_t population(uint32_t place) const { return populations_[place]; }
  void SetPopulation(uint32_t place, uint8_t population) {
    populations_[place] = population;
    if (hides_others_) shown_[place] = population == 0 ? boxes_[place] : kInvalidAabb;
  }
  // Returns the slots of all proxies, indexed by place. The slot of a proxy is its position in the
  // tree of its population. The trees write the slots.
  std::span<uint32_t> slots() { return slots_; }

  // Returns the boxes, indexed by place; a free place has an invalid box.
  std::span<const Aabb> boxes() const { return boxes_; }
  std::span<const CollisionFilter> filters() const { return filters_; }
  // Returns the boxes of population 0, with invalid boxes at all other places. REQUIRES: HideOthers
  // was called, or all proxies are in population 0.
  std::span<const Aabb> shown_boxes() const { return hides_others_ ? shown_ : boxes_; }
  // Makes shown_boxes hide the proxies outside population 0. If shown_boxes is used, this must be
  // called before the first proxy leaves population 0. Cost: O(places) the first time.
  void HideOthers();

  // Frees the free places at the end, down to `min_places`, and unused capacity. Existing handles
  // stay unique. Cost: O(places).
  void Compact(size_t min_places);

  size_t count() const { return boxes_.size() - free_count_; }
  // Returns whether every proxy has the default filter.
  bool all_pass() const { return filtered_count_ == 0; }

  // Returns the generation at the last MarkSeen.
  uint32_t seen_generation(uint32_t place) const { return seen_[place]; }
  // Returns whether a proxy has been added since the last MarkSeen.
  bool any_new_owner() const { return !new_owners_.empty(); }
  // Returns whether the proxy at the place has been added since the last MarkSeen.
  bool HasNewOwner(uint32_t place) const { return seen_[place] != generations_[place]; }
  // Marks the present owners as seen. Cost: O(places with new owners).
  void MarkSeen();

  // Passes the fields of a snapshot to `archive` (snapshot.h). FinishRestore must follow a restore.
  template <typename Self, typename Archive>
  static void Visit(Self& self, Archive& archive) {
    archive.Array(self.boxes_);
    archive.Array(self.filters_);
    archive.Array(self.users_);
    archive.Array(self.generations_);
    archive.Array(self.seen_);
    archive.Array(self.slots_);
    archive.Array(self.populations_);
    archive.Array(self.new_owners_);
    archive.Value(self.hides_others_);
    archive.Value(self.freed_last_);
    archive.Value(self.free_count_);
    archive.Value(self.filtered_count_);
    archive.Value(self.first_generation_);
  }
  void FinishRestore();

  size_t native_bytes() const;

 private:
  static constexpr uint32_t kNoPlace = ~0U;

  // A generation is odd while the place is taken.
  static bool IsOdd(uint32_t generation) { return (generation & 1) != 0; }

  void EnsureRoomForOne();
  void Reserve(size_t places);
  void Truncate(size_t places);
  void LinkFreePlaces();
  bool AnyHidden() const;
  uint32_t TakePlace();

  bool notes_owners_;
  HookedVector<Aabb> boxes_;
  bool hides_others_ = false;
  HookedVector<Aabb> shown_;  // empty until HideOthers
  HookedVector<CollisionFilter> filters_;
  HookedVector<uint64_t> users_;
  HookedVector<uint32_t> generations_;
  HookedVector<uint32_t> seen_;  // the generations at the last MarkSeen
  // The slot of the proxy at each place in its tree. At a free place it holds the place that was
  // freed before this one.
  HookedVector<uint32_t> slots_;
  HookedVector<uint8_t> populations_;
  // The places with new owners since the last MarkSeen, each once.
  HookedVector<uint32_t> new_owners_;
  uint32_t freed_last_ = kNoPlace;
  size_t free_count_ = 0;
  size_t filtered_count_ = 0;
  // The generation at which new places begin. It is at least the generation of every place that
  // Compact has removed.
  uint32_t first_generation_ = 0;
};

}  // namespace sweepstake
