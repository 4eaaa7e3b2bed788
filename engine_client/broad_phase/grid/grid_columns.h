// Boxes as six float columns one stride apart and their ids, in an order that is given slot by
// slot: what grid_search.h reads.
//
// Not thread-safe, but parts may gather disjoint ranges of slots at once. Owns its memory. Memory:
// 28 bytes per slot.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/common/aligned_buffer.h"
#include "engine_client/broad_phase/common/soa_boxes.h"
#include "sweepstake/aabb.h"

namespace sweepstake {

class GridColumns {
 public:
  // Room for `count` slots, whose content is then undefined, and a register to read past them.
  void Resize(size_t count);
  // For the caller to write; Gather reads them.
  uint32_t* ids() { return ids_.data(); }
  const uint32_t* ids() const { return ids_.data(); }
  // The slots [begin, end) take boxes[id].
  void Gather(std::span<const Aabb> boxes, size_t begin, size_t end);

  // The box of the slot then overlaps nothing.
  void Blind(size_t slot);

  BoxLanes lanes() const;
  size_t native_bytes() const { return floats_.capacity_bytes() + ids_.capacity_bytes(); }

 private:
  AlignedBuffer<float> floats_;  // min x y z, max x y z; stride_ floats each
  AlignedBuffer<uint32_t> ids_;
  size_t count_ = 0;
  size_t stride_ = 0;
};

}  // namespace sweepstake
