// Boxes as six arrays of floats (columns) and an array of ids, the layout that vector kernels read.
//
// Not thread-safe. Owns its memory. Cost of Gather: O(n), 28 bytes written per box. Memory: 28 (n +
// kPadding) bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/common/aligned_buffer.h"
#include "sweepstake/aabb.h"

namespace sweepstake {

// A view of SoaBoxes, valid until its next Gather. The caller chooses the first axis, and the
// others follow in cyclic order. Overlap does not depend on the order of the axes.
struct BoxLanes {
  const float* min[3];
  const float* max[3];
  const uint32_t* id;
  size_t count;
};

class SoaBoxes {
 public:
  // The number of sentinels behind the last box, at least one register of every target: a kernel
  // may read [i, i + lanes) for any i <= count. A sentinel (min = +inf, max = -inf) overlaps
  // nothing, not even another sentinel.
  static constexpr size_t kPadding = 64;

  // Puts boxes[k] with id k in slot k, and a sentinel with this id for an invalid box (aabb.h).
  void Gather(std::span<const Aabb> boxes);
  // Puts boxes[order[k]] with id order[k] in slot k, and a sentinel with this id for an invalid
  // box. REQUIRES: every entry is an index of `boxes`.
  void Gather(std::span<const Aabb> boxes, std::span<const uint32_t> order);

  size_t count() const { return count_; }
  BoxLanes Lanes(int first_axis = 0) const;
  size_t native_bytes() const { return floats_.capacity_bytes() + ids_.capacity_bytes(); }

 private:
  void Resize(size_t count);
  void Finish();
  float* Column(size_t index) { return floats_.data() + index * stride_; }

  AlignedBuffer<float> floats_;  // the columns min x, y, z, max x, y, z, each of stride_ floats
  AlignedBuffer<uint32_t> ids_;
  size_t count_ = 0;
  size_t stride_ = 0;
};

}  // namespace sweepstake
