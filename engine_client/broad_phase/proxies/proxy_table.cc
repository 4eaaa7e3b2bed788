#include "engine_client/broad_phase/proxies/proxy_table.h"

#include <algorithm>

namespace sweepstake {

uint32_t ProxyTable::Add(const Aabb& box, const CollisionFilter& filter, uint64_t user) {
  if (freed_last_ == kNoPlace) EnsureRoomForOne();
  const uint32_t place = TakePlace();
  // A place that gets several new proxies between two calls of MarkSeen is listed only once.
  if (notes_owners_ && generations_[place] - seen_[place] <= 1) new_owners_.push_back(place);
  ++generations_[place];
  filters_[place] = filter;
  users_[place] = user;
  populations_[place] = 0;
  SetBox(place, box);
  if (filter != CollisionFilter{}) ++filtered_count_;
  return place;
}

uint32_t ProxyTable::TakePlace() {
  if (freed_last_ != kNoPlace) {
    const uint32_t place = freed_last_;
    freed_last_ = slots_[place];
    --free_count_;
    return place;
  }
  if (hides_others_) shown_.push_back(kInvalidAabb);
  boxes_.push_back(kInvalidAabb);
  filters_.emplace_back();
  users_.push_back(0);
  generations_.push_back(first_generation_);
  seen_.push_back(first_generation_);
  slots_.push_back(0);
  populations_.push_back(0);
  return static_cast<uint32_t>(boxes_.size() - 1);
}

void ProxyTable::EnsureRoomForOne() {
  if (boxes_.size() == kMaxPlaces) OutOfMemory();
  // `boxes_` grows last: if another array failed to grow, the next Add tries again.
  if (boxes_.size() < boxes_.capacity()) return;
  Reserve(std::max<size_t>(64, boxes_.size() * 2));
}

void ProxyTable::Reserve(size_t places) {
  if (hides_others_) shown_.reserve(places);
  filters_.reserve(places);
  users_.reserve(places);
  generations_.reserve(places);
  seen_.reserve(places);
  slots_.reserve(places);
  populations_.reserve(places);
  if (notes_owners_) new_owners_.reserve(places);
  boxes_.reserve(places);
}

void ProxyTable::HideOthers() {
  if (hides_others_) return;
  shown_.reserve(boxes_.capacity());
  shown_ = boxes_;
  hides_others_ = true;
}

void ProxyTable::Remove(uint32_t place) {
  SetFilter(place, {});
  SetBox(place, kInvalidAabb);
  ++generations_[place];
  slots_[place] = freed_last_;
  freed_last_ = place;
  ++free_count_;
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

void ProxyTable::FinishRestore() {
  Reserve(boxes_.capacity());
  shown_.clear();
  if (!hides_others_) return;
  for (uint32_t place = 0; place < boxes_.size(); ++place) {
    shown_.push_back(populations_[place] == 0 ? boxes_[place] : kInvalidAabb);
  }
}

void ProxyTable::Compact(size_t min_places) {
  size_t places = boxes_.size();
  for (; places > min_places && !IsOdd(generations_[places - 1]); --places) {
    first_generation_ = std::max(first_generation_, generations_[places - 1]);
  }
  Truncate(places);
  LinkFreePlaces();
  if (hides_others_ && !AnyHidden()) {
    shown_ = {};
    hides_others_ = false;
  }
}

void ProxyTable::Truncate(size_t places) {
  std::erase_if(new_owners_, [&](uint32_t place) { return place >= places; });
  const auto shrink = [&](auto& of_places) {
    of_places.resize(std::min(of_places.size(), places));
    of_places.shrink_to_fit();
  };
  shrink(shown_);
  shrink(filters_);
  shrink(users_);
  shrink(generations_);
  shrink(seen_);
  shrink(slots_);
  shrink(populations_);
  shrink(boxes_);
}

// Links the free places so that the lowest one is used next.
void ProxyTable::LinkFreePlaces() {
  freed_last_ = kNoPlace;
  free_count_ = 0;
  for (auto place = static_cast<uint32_t>(boxes_.size()); place-- > 0;) {
    if (IsOdd(generations_[place])) continue;
    slots_[place] = freed_last_;
    freed_last_ = place;
    ++free_count_;
  }
}

bool ProxyTable::AnyHidden() const {
  for (uint32_t place = 0; place < boxes_.size(); ++place) {
    if (populations_[place] != 0 && IsOdd(generations_[place])) return true;
  }
  return false;
}

size_t ProxyTable::native_bytes() const {
  return (boxes_.capacity() + shown_.capacity()) * sizeof(Aabb) +
         filters_.capacity() * sizeof(CollisionFilter) + users_.capacity() * sizeof(uint64_t) +
         (generations_.capacity() + seen_.capacity() + slots_.capacity() + new_owners_.capacity()) *
             sizeof(uint32_t) +
         populations_.capacity();
}

}  // namespace sweepstake
