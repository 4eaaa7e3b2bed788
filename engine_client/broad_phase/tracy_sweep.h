// Sweeps the cells of the Tracy family. Kernels are chosen at run time once per call.
//
// Not thread-safe. Borrows everything for the call. Cost: O(entries) where little has changed, plus
// the checks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/aligned_buffer.h"
#include "engine_client/broad_phase/cell_lists.h"
#include "engine_client/broad_phase/grid_layout.h"
#include "engine_client/broad_phase/soa_boxes.h"
#include "sweepstake/aabb.h"
#include "sweepstake/pair_buffer.h"

namespace sweepstake {

// Room for one cell's boxes, reused from cell to cell and kept between frames.
class SweepRoom {
 public:
  struct Entry {
    float key;
    uint32_t id;
  };

  void Ensure(size_t entry_count);

  Entry* entries() { return entries_.data(); }
  // Column k: min of the k-th axis from the sweep axis on, column 3 + k: max.
  float* column(size_t index) { return floats_.data() + index * stride_; }
  uint32_t* ids() { return words_.data(); }
  uint32_t* marks() { return words_.data() + stride_; }
  size_t native_bytes() const {
    return entries_.capacity_bytes() + floats_.capacity_bytes() + words_.capacity_bytes();
  }

 private:
  AlignedBuffer<Entry> entries_;
  AlignedBuffer<float> floats_;
  AlignedBuffer<uint32_t> words_;
  size_t stride_ = 0;
};

struct SweepInput {
  // Those that do not take part are sentinels (soa_boxes.h).
  std::span<const Aabb> boxes;
  const GridLayout& layout;
  // The sweep axis.
  size_t axis;
};

// Sorts each list along the sweep axis, drops the boxes that are no longer in the cell, and appends
// the pairs which this cell is the one to report. Returns the AABB checks.
uint64_t SweepCells(const SweepInput& input, CellLists& lists, SweepRoom& room, PairBuffer& out);

// The same without looking for pairs.
void TidyCells(const SweepInput& input, CellLists& lists, SweepRoom& room);

}  // namespace sweepstake
