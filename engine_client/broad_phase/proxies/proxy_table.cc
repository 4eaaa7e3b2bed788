#include "engine_client/broad_phase/proxies/proxy_table.h"

#include <algorithm>

#include "engine_client/broad_phase/common/box_record.h"

namespace sweepstake {
namespace {

// The owners of ids, in this frame and in the last one.
class Owners {
 public:
  Owners(const ProxyTable& moving, const ProxyTable& resting)
      : moving_(moving),
        resting_(resting),
        any_new_(moving.any_new_owner() || resting.any_new_owner()) {}

  ProxyPair Now(const OverlapPair& pair) const {
    return {{pair.a, TableOf(pair.a).generation(PlaceOf(pair.a))},
            {pair.b, TableOf(pair.b).generation(PlaceOf(pair.b))}};
  }
  ProxyPair Before(const OverlapPair& pair) const {
    return {{pair.a, TableOf(pair.a).seen_generation(PlaceOf(pair.a))},
            {pair.b, TableOf(pair.b).seen_generation(PlaceOf(pair.b))}};
  }
  // Returns whether a pair of both frames has other owners now.
  bool Changed(const OverlapPair& pair) const {
    return any_new_ && (TableOf(pair.a).HasNewOwner(PlaceOf(pair.a)) ||
                        TableOf(pair.b).HasNewOwner(PlaceOf(pair.b)));
  }

 private:
  static uint32_t PlaceOf(uint32_t id) { return id & ~kStaticProxyBit; }
  const ProxyTable& TableOf(uint32_t id) const {
    return (id & kStaticProxyBit) != 0 ? resting_ : moving_;
  }

  const ProxyTable& moving_;
  const ProxyTable& resting_;
  const bool any_new_;
};

}  // namespace

uint32_t ProxyTable::Add(const Aabb& box, const CollisionFilter& filter, uint64_t user) {
  if (free_.empty()) EnsureRoomForOne();
  const uint32_t place = TakePlace();
  // The place is not in the list yet if its owner at the last MarkSeen is still there or was the
  // latest one.
  if (generations_[place] - seen_[place] <= 1) new_owners_.push_back(place);
  ++generations_[place];
  boxes_[place] = box;
  filters_[place] = filter;
  users_[place] = user;
  if (filter != CollisionFilter{}) ++filtered_count_;
  changed_ = true;
  return place;
}

uint32_t ProxyTable::TakePlace() {
  if (!free_.empty()) {
    const uint32_t place = free_.back();
    free_.pop_back();
    return place;
  }
  boxes_.push_back(kInvalidAabb);
  filters_.emplace_back();
  users_.push_back(0);
  generations_.push_back(0);
  seen_.push_back(0);
  return static_cast<uint32_t>(boxes_.size() - 1);
}

void ProxyTable::EnsureRoomForOne() {
  if (boxes_.size() == kMaxPlaces) OutOfMemory();
  // `boxes_` grows last: if another array failed to grow, the next Add tries again.
  if (boxes_.size() < boxes_.capacity()) return;
  const size_t places = std::max<size_t>(64, boxes_.size() * 2);
  filters_.reserve(places);
  users_.reserve(places);
  generations_.reserve(places);
  seen_.reserve(places);
  free_.reserve(places);
  new_owners_.reserve(places);
  boxes_.reserve(places);
}

void ProxyTable::Remove(uint32_t place) {
  SetFilter(place, {});
  boxes_[place] = kInvalidAabb;
  ++generations_[place];
  free_.push_back(place);
  changed_ = true;
}

void ProxyTable::SetFilter(uint32_t place, const CollisionFilter& filter) {
  if (filters_[place] != CollisionFilter{}) --filtered_count_;
  if (filter != CollisionFilter{}) ++filtered_count_;
  filters_[place] = filter;
}

void ProxyTable::MarkSeen() {
  for (const uint32_t place : new_owners_) seen_[place] = generations_[place];
  new_owners_.clear();
}

size_t ProxyTable::native_bytes() const {
  return boxes_.capacity() * sizeof(Aabb) + filters_.capacity() * sizeof(CollisionFilter) +
         users_.capacity() * sizeof(uint64_t) +
         (generations_.capacity() + seen_.capacity() + free_.capacity() + new_owners_.capacity()) *
             sizeof(uint32_t);
}

void PairEvents::Compare(std::span<const OverlapPair> before, std::span<const OverlapPair> now,
                         const ProxyTable& moving, const ProxyTable& resting) {
  const Owners owners(moving, resting);
  added_.clear();
  removed_.clear();
  size_t b = 0;
  size_t n = 0;
  while (b < before.size() && n < now.size()) {
    const uint64_t key_before = PairKey(before[b]);
    const uint64_t key_now = PairKey(now[n]);
    // Most pairs persist, so that this branch is well predicted.
    if (key_before == key_now && !owners.Changed(now[n])) {
      ++b;
      ++n;
      continue;
    }
    if (key_before <= key_now) removed_.push_back(owners.Before(before[b++]));
    if (key_now <= key_before) added_.push_back(owners.Now(now[n++]));
  }
  while (b < before.size()) removed_.push_back(owners.Before(before[b++]));
  while (n < now.size()) added_.push_back(owners.Now(now[n++]));
}

}  // namespace sweepstake
