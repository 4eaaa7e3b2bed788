#include "engine_client/broad_phase/proxies/proxy_table.h"

#include <bit>
#include <utility>

namespace sweepstake {

uint32_t ProxyTable::EnsureRoomForOne() {
  const uint32_t id = row_of_.LowestFree();
  // `boxes_` grows last: if another column failed to grow, the next call tries again.
  if (boxes_.size() == boxes_.capacity()) Reserve(CapacityFor(boxes_.size() + 1));
  return id;
}

uint32_t ProxyTable::AppendHole() {
  const uint32_t row = row_count();
  boxes_.push_back(kInvalidAabb);
  filters_.emplace_back();
  users_.push_back(0);
  ids_.push_back(kNoId);
  generations_.push_back(0);
  slots_.push_back(0);
  populations_.push_back(0);
  NoteHole(row);
  peak_count_ = std::max(peak_count_, boxes_.size());
  return row;
}

void ProxyTable::RemoveLastRow() {
  NoteFilled(row_count() - 1);
  boxes_.pop_back();
  filters_.pop_back();
  users_.pop_back();
  ids_.pop_back();
  generations_.pop_back();
  slots_.pop_back();
  populations_.pop_back();
}

void ProxyTable::Fill(uint32_t hole, uint32_t id, const Aabb& box, const CollisionFilter& filter,
                      uint64_t user) {
  NoteFilled(hole);
  row_of_.Take(id, hole);
  latest_generation_ = NextGeneration(latest_generation_);
  ids_[hole] = id | id_bit_;
  generations_[hole] = latest_generation_;
  boxes_[hole] = box;
  users_[hole] = user;
  SetFilter(hole, filter);
  displaced_count_ += IsDisplaced(hole);
}

void ProxyTable::Empty(uint32_t row) {
  displaced_count_ -= IsDisplaced(row);
  SetFilter(row, {});
  boxes_[row] = kInvalidAabb;
  row_of_.Free(ids_[row] ^ id_bit_);
  ids_[row] = kNoId;
  generations_[row] = 0;
  any_removed_ = true;
  NoteHole(row);
}

void ProxyTable::Swap(uint32_t a, uint32_t b) {
  displaced_count_ -= IsDisplaced(a) + IsDisplaced(b);
  std::swap(boxes_[a], boxes_[b]);
  std::swap(filters_[a], filters_[b]);
  std::swap(users_[a], users_[b]);
  std::swap(ids_[a], ids_[b]);
  std::swap(generations_[a], generations_[b]);
  std::swap(slots_[a], slots_[b]);
  std::swap(populations_[a], populations_[b]);
  displaced_count_ += IsDisplaced(a) + IsDisplaced(b);
  if (!is_hole(a)) row_of_.SetRow(ids_[a] ^ id_bit_, a);
  if (!is_hole(b)) row_of_.SetRow(ids_[b] ^ id_bit_, b);
  if (is_hole(a) == is_hole(b)) return;
  NoteFilled(is_hole(a) ? b : a);
  NoteHole(is_hole(a) ? a : b);
}

uint32_t ProxyTable::LowestHole() {
  while (holes_[first_word_] == 0) ++first_word_;
  return static_cast<uint32_t>(first_word_ * 64) +
         static_cast<uint32_t>(std::countr_zero(holes_[first_word_]));
}

void ProxyTable::NoteHole(uint32_t row) {
  holes_[row / 64] |= uint64_t{1} << row % 64;
  first_word_ = std::min<size_t>(first_word_, row / 64);
  ++hole_count_;
}

void ProxyTable::NoteFilled(uint32_t row) {
  holes_[row / 64] &= ~(uint64_t{1} << row % 64);
  --hole_count_;
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
  ids_.reserve(rows);
  generations_.reserve(rows);
  slots_.reserve(rows);
  populations_.reserve(rows);
  holes_.resize(std::max(holes_.size(), (rows + 63) / 64));
  boxes_.reserve(rows);
}

bool ProxyTable::FreeUnused() {
  row_of_.FreeUnused();
  const size_t needed_before = std::exchange(needed_count_, peak_count_);
  peak_count_ = boxes_.size();
  return CapacityFor(needed_count_) < CapacityFor(needed_before);
}

void ProxyTable::ShrinkRows() {
  const size_t capacity = CapacityFor(std::max(needed_count_, peak_count_));
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
  shrink(ids_);
  shrink(generations_);
  shrink(slots_);
  if (is_oversized) {
    holes_.resize(capacity / 64);
    holes_.shrink_to_fit();
  }
  shrink(populations_);
}

void ProxyTable::FinishRestore() {
  Reserve(boxes_.capacity());
  row_of_.Assign(ids_, id_bit_);
  std::fill(holes_.begin(), holes_.end(), 0);
  hole_count_ = first_word_ = 0;
  for (uint32_t row = 0; row < row_count(); ++row) {
    if (is_hole(row)) NoteHole(row);
  }
  peak_count_ = std::max(peak_count_, boxes_.size());
}

size_t ProxyTable::native_bytes() const {
  return row_of_.native_bytes() + boxes_.capacity() * sizeof(Aabb) +
         filters_.capacity() * sizeof(CollisionFilter) +
         (users_.capacity() + holes_.capacity()) * sizeof(uint64_t) +
         (ids_.capacity() + generations_.capacity() + slots_.capacity()) * sizeof(uint32_t) +
         populations_.capacity();
}

}  // namespace sweepstake
