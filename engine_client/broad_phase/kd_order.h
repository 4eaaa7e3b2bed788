// An order of boxes in which neighbours in space stand together: recursive splits at the median of
// the widest axis.
//
// Not thread-safe. Owns its memory. Cost: O(n log n), about 75 ns per box at 10,000. Memory: 16
// bytes per box.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/aligned_buffer.h"
#include "sweepstake/aabb.h"

namespace sweepstake {

class KdOrder {
 public:
  // Splits end at parts of this many boxes. Larger parts are split at the multiple of 16, 256, 4096
  // … boxes nearest to the median, so that aligned runs of as many boxes never straddle a split.
  static constexpr uint32_t kPart = 16;

  // Rearranges `order`, a permutation of the boxes' indices; the closer it already is, the faster.
  // Boxes that do not take part go to the end.
  void Sort(std::span<const Aabb> boxes, std::span<uint32_t> order);

  size_t native_bytes() const { return centers_.capacity_bytes(); }

 private:
  struct Center {
    float at[3];
    uint32_t box;
  };

  size_t CollectCenters(std::span<const Aabb> boxes, std::span<const uint32_t> order);
  void SplitAll(size_t count);
  void Split(size_t begin, size_t middle, size_t end);
  int WidestAxis(size_t begin, size_t end) const;

  AlignedBuffer<Center> centers_;
};

}  // namespace sweepstake
