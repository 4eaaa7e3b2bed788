#include "engine_client/broad_phase/proxies/proxy_table.h"

#include <algorithm>
#include <limits>
#include <new>

namespace sweepstake {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr Aabb kAbsent = {{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};

}  // namespace

uint32_t ProxyTable::Add(const Aabb& box, const CollisionFilter& filter, uint64_t user) {
  if (free_.empty()) EnsureRoomForOne();
  const uint32_t place = TakePlace();
  // Not in the list: its owner of then is still there, or was the latest one.
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
  boxes_.push_back(kAbsent);
  filters_.emplace_back();
  users_.push_back(0);
  generations_.push_back(0);
  seen_.push_back(0);
  return static_cast<uint32_t>(boxes_.size() - 1);
}

void ProxyTable::EnsureRoomForOne() {
  if (boxes_.size() == kMaxPlaces) throw std::bad_alloc();
  // The one that grows last: had another failed to grow, this one would try again.
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
  boxes_[place] = kAbsent;
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

}  // namespace sweepstake
