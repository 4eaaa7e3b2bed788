// A list of ids per cell, all in one array.
//
// A list that outgrows its place moves to the end of the array; when that is full, all lists are
// packed anew into a second array, with room to grow. So lists that keep changing while their total
// does not allocate nothing.
//
// Not thread-safe. Owns its memory. Cost: Append O(1) amortised. Memory: 16 bytes per cell, and 15
// per id with all slack.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/aligned_buffer.h"

namespace sweepstake {

class CellLists {
 public:
  // That many empty lists with room for as many ids as given, and some. Takes memory for
  // `most_cells` lists, so that another Reset with up to as many need not.
  void Reset(std::span<const uint32_t> expected_sizes, size_t most_cells);

  size_t size() const { return cell_count_; }
  std::span<uint32_t> ids(size_t cell) {
    return {pool_.data() + cells_[cell].begin, cells_[cell].count};
  }
  void Append(size_t cell, uint32_t id) {
    if (cells_[cell].count == cells_[cell].capacity) Grow(cell);
    pool_[cells_[cell].begin + cells_[cell].count++] = id;
  }
  // Keeps the first `count` ids. REQUIRES: there are as many.
  void Truncate(size_t cell, size_t count) { cells_[cell].count = static_cast<uint32_t>(count); }

  size_t native_bytes() const {
    return cells_.capacity_bytes() + pool_.capacity_bytes() + spare_.capacity_bytes();
  }

 private:
  struct Cell {
    uint32_t count;
    uint32_t capacity;
    size_t begin;
  };

  void Grow(size_t cell);
  void Repack();

  AlignedBuffer<Cell> cells_;
  AlignedBuffer<uint32_t> pool_;
  AlignedBuffer<uint32_t> spare_;
  size_t cell_count_ = 0;
  size_t used_ = 0;  // of the pool; places that lists have left included
};

}  // namespace sweepstake
