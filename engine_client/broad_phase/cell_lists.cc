#include "engine_client/broad_phase/cell_lists.h"

#include <algorithm>
#include <utility>

namespace sweepstake {
namespace {

constexpr uint32_t WithRoom(uint32_t count) { return count + count / 4 + 4; }

// Lists that move take the second half; what is left at a packing is less only after growth that
// lasts.
constexpr size_t PoolSize(size_t used) { return used + used / 2 + 1024; }
constexpr size_t LeastPoolSize(size_t used) { return used + used / 8 + 64; }

}  // namespace

void CellLists::Reset(std::span<const uint32_t> expected_sizes, size_t most_cells) {
  cell_count_ = expected_sizes.size();
  cells_.EnsureDiscarding(std::max(cell_count_, most_cells));
  used_ = 0;
  for (size_t cell = 0; cell < cell_count_; ++cell) {
    cells_[cell] = {0, WithRoom(expected_sizes[cell]), used_};
    used_ += cells_[cell].capacity;
  }
  if (LeastPoolSize(used_) > pool_.capacity()) pool_.EnsureDiscarding(PoolSize(used_));
  spare_.EnsureDiscarding(pool_.capacity());
}

void CellLists::Grow(size_t cell) {
  const size_t capacity = 2 * size_t{cells_[cell].capacity};
  if (used_ + capacity > pool_.capacity()) {
    Repack();  // leaves room in every list
    return;
  }
  const std::span<const uint32_t> old = ids(cell);
  std::copy(old.begin(), old.end(), pool_.data() + used_);
  cells_[cell].begin = used_;
  cells_[cell].capacity = static_cast<uint32_t>(capacity);
  used_ += capacity;
}

void CellLists::Repack() {
  size_t needed = 0;
  for (size_t cell = 0; cell < cell_count_; ++cell) needed += WithRoom(cells_[cell].count);
  if (LeastPoolSize(needed) > spare_.capacity()) spare_.EnsureDiscarding(PoolSize(needed));
  used_ = 0;
  for (size_t cell = 0; cell < cell_count_; ++cell) {
    const std::span<const uint32_t> old = ids(cell);
    std::copy(old.begin(), old.end(), spare_.data() + used_);
    cells_[cell].begin = used_;
    cells_[cell].capacity = WithRoom(cells_[cell].count);
    used_ += cells_[cell].capacity;
  }
  std::swap(pool_, spare_);
}

}  // namespace sweepstake
