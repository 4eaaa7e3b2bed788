#include "engine_client/broad_phase/proxies/proxy_table.h"

#include <bit>
#include <utility>

namespace sweepstake {

void ProxyTable::Add(const Aabb& box, const CollisionFilter& filter, uint64_t user) {
  const uint32_t id = ids_.LowestFree();
  // `boxes_` grows last: if another column failed to grow, the next Add tries again.
  if (boxes_.size() == boxes_.capacity()) Reserve(CapacityFor(boxes_.size() + 1));
  const auto row = static_cast<uint32_t>(boxes_.size());
  ids_.Take(id, row);
  latest_generation_ = NextGeneration(latest_generation_);
  boxes_.push_back(box);
  filters_.push_back(filter);
  users_.push_back(user);
  handles_.push_back({id | id_bit_, latest_generation_});
  slots_.push_back(0);
  populations_.push_back(0);
  if (filter != CollisionFilter{}) ++filtered_count_;
  displaced_count_ += static_cast<size_t>(IsDisplaced(row));
  peak_count_ = std::max(peak_count_, count());
}

void ProxyTable::RemoveLast() {
  const auto row = static_cast<uint32_t>(boxes_.size() - 1);
  SetFilter(row, {});
  displaced_count_ -= static_cast<size_t>(IsDisplaced(row));
  ids_.Free(handles_[row].index ^ id_bit_);
  boxes_.pop_back();
  filters_.pop_back();
  users_.pop_back();
  handles_.pop_back();
  slots_.pop_back();
  populations_.pop_back();
  any_removed_ = true;
}

void ProxyTable::Swap(uint32_t a, uint32_t b) {
  const auto displaced = [&] {
    return static_cast<size_t>(IsDisplaced(a)) + static_cast<size_t>(IsDisplaced(b));
  };
  displaced_count_ -= displaced();
  std::swap(boxes_[a], boxes_[b]);
  std::swap(filters_[a], filters_[b]);
  std::swap(users_[a], users_[b]);
  std::swap(handles_[a], handles_[b]);
  std::swap(slots_[a], slots_[b]);
  std::swap(populations_[a], populations_[b]);
  ids_.SetRow(handles_[a].index ^ id_bit_, a);
  ids_.SetRow(handles_[b].index ^ id_bit_, b);
  displaced_count_ += displaced();
}

void ProxyTable::SetFilter(uint32_t row, const CollisionFilter& filter) {
  if (filters_[row] != CollisionFilter{}) --filtered_count_;
  if (filter != CollisionFilter{}) ++filtered_count_;
  filters_[row] = filter;
}

// Returns a power of two, so that the capacity depends on the number of rows alone.
size_t ProxyTable::CapacityFor(size_t rows) { return std::bit_ceil(std::max<size_t>(64, rows)); }

void ProxyTable::Reserve(size_t rows) {
  filters_.reserve(rows);
  users_.reserve(rows);
  handles_.reserve(rows);
  slots_.reserve(rows);
  populations_.reserve(rows);
  boxes_.reserve(rows);
}

bool ProxyTable::FreeUnused() {
  ids_.FreeUnused();
  const size_t capacity = CapacityFor(peak_count_);
  const bool is_oversized = populations_.capacity() > capacity;
  const auto shrink = [&](auto& column) {
    if (column.capacity() <= capacity) return;
    std::remove_reference_t<decltype(column)> smaller;
    smaller.reserve(capacity);
    smaller.assign(column.begin(), column.end());
    column.swap(smaller);
  };
  // The first and the last column are those that Add and this function look at. So both try again
  // if memory runs out in between.
  shrink(boxes_);
  shrink(filters_);
  shrink(users_);
  shrink(handles_);
  shrink(slots_);
  shrink(populations_);
  peak_count_ = count();
  return is_oversized;
}

void ProxyTable::FinishRestore() {
  Reserve(boxes_.capacity());
  ids_.Clear();
  for (uint32_t row = 0; row < count(); ++row) ids_.Insert(handles_[row].index ^ id_bit_, row);
  peak_count_ = std::max(peak_count_, count());
}

size_t ProxyTable::native_bytes() const {
  return ids_.native_bytes() + boxes_.capacity() * sizeof(Aabb) +
         filters_.capacity() * sizeof(CollisionFilter) + users_.capacity() * sizeof(uint64_t) +
         handles_.capacity() * sizeof(ProxyHandle) + slots_.capacity() * sizeof(uint32_t) +
         populations_.capacity();
}

}  // namespace sweepstake
