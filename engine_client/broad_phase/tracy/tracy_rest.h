// What Tracy keeps while little moves: each box enlarged by a margin, and the pairs of enlarged
// boxes that overlap.
//
// The lists then hold the enlarged boxes and stay as they are. A frame looks whether each box is
// still within its margin and tests the kept pairs. A box that has left its margin is loose until
// the next Start: it takes no part in the kept pairs and looks for partners in the lists by itself.
//
// Not thread-safe. Owns its memory. Cost: Start about one frame of the lists; Step 6 ns per box,
// 50 ns per loose one. Memory: 26 bytes per box and 9 per kept pair.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/common/aligned_buffer.h"
#include "engine_client/broad_phase/common/parallel.h"
#include "engine_client/broad_phase/tracy/tracy_lists.h"
#include "sweepstake/aabb.h"
#include "sweepstake/executor.h"
#include "sweepstake/pair_buffer.h"

namespace sweepstake {

class TracyRest {
 public:
  // Encloses the boxes in margins and brings `lists` to these. Returns the AABB checks.
  uint64_t Start(Executor* executor, std::span<const Aabb> boxes, float margin, TracyLists& lists);
  // Takes the boxes of the next frame. False: so many are loose that it no longer pays, or there
  // are more or fewer; `lists` needs an Update then. Adds the AABB checks made to `checks`.
  // REQUIRES: a Start or Step before that returned true, on the same lists.
  bool Step(Executor* executor, std::span<const Aabb> boxes, TracyLists& lists, uint64_t& checks);
  // The overlapping pairs of the latest boxes.
  void Append(PairBuffer& out) const;

  size_t native_bytes() const;

 private:
  size_t MostLoose() const;
  void Loosen(std::span<const uint32_t> left, TracyLists& lists);
  void TestPairs(Executor* executor, std::span<const Aabb> boxes);

  AlignedBuffer<Aabb> margins_;  // per object; of a loose one all space, of an absent one none
  AlignedBuffer<uint8_t> is_loose_;
  size_t count_ = 0;
  AlignedBuffer<uint32_t> left_;
  AlignedBuffer<uint32_t> loose_;
  size_t loose_count_ = 0;
  PairBuffer kept_;
  AlignedBuffer<uint8_t> overlaps_;  // per kept pair
  PairBuffer loose_pairs_;
  PairParts parts_;
};

}  // namespace sweepstake
