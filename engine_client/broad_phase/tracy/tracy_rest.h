// The state that Tracy keeps while little moves: each box enlarged by a margin, and the overlapping
// pairs of enlarged boxes.
//
// The lists hold the enlarged boxes and do not change. A frame checks whether each box is still
// within its margin and tests the kept pairs. A box that has left its margin counts as outside
// until the next Start: its kept pairs are ignored, and it searches the lists itself.
//
// Not thread-safe. Owns its memory. Cost: Start about one frame of the lists; Step O(n + kept
// pairs), and a search per box outside its margin. Memory: 26 bytes per box and 9 per kept pair.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/common/aligned_buffer.h"
#include "engine_client/broad_phase/common/parallel.h"
#include "engine_client/broad_phase/tracy/tracy_lists.h"
#include "sweepstake/aabb.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/executor.h"
#include "sweepstake/pair_buffer.h"

namespace sweepstake {

class TracyRest {
 public:
  // Enlarges the boxes by `margin` on each side, in the coordinates of the grids, updates `lists`
  // to the enlarged boxes, and adds the AABB checks made to `checks`. Returns false if the enlarged
  // boxes have more than kMaxKeptPerBox pairs per box; `lists` then needs an Update. Start and Step
  // poll `stop`, which may be null.
  bool Start(Executor* executor, const GridBoxes& boxes, float margin, TracyLists& lists,
             uint64_t& checks, StopRequest* stop);
  // Updates the state from the boxes of the next frame and adds the AABB checks made to `checks`.
  // Returns false if too many boxes are outside their margins, if these have more than
  // kMaxKeptPerBox pairs per box of the scene, or if the number of boxes has changed; `lists` then
  // needs an Update. REQUIRES: the last call was a Start or Step that returned true,
  // with the same lists.
  bool Step(Executor* executor, const GridBoxes& boxes, TracyLists& lists, uint64_t& checks,
            StopRequest* stop);
  // Appends the overlapping pairs of the latest boxes.
  void Append(PairBuffer& out) const;

  size_t native_bytes() const;

  static constexpr size_t kMaxKeptPerBox = 16;

 private:
  size_t MaxOutsideCount() const;
  void AddOutside(std::span<const uint32_t> listed, TracyLists& lists);
  void TestPairs(Executor* executor, std::span<const Aabb> boxes, StopRequest* stop);

  // The enlarged box of each object. It is infinite for an object that has left its margin since
  // Start, and NaN for an object whose box was invalid at Start.
  AlignedBuffer<Aabb> margins_;
  AlignedBuffer<uint8_t> is_outside_;
  size_t count_ = 0;
  AlignedBuffer<uint32_t> listed_;   // the boxes that left their margins in the latest Step
  AlignedBuffer<uint32_t> outside_;  // the boxes that left their margins since the latest Start
  size_t outside_count_ = 0;
  PairBuffer kept_;
  AlignedBuffer<uint8_t> overlaps_;  // whether each kept pair overlaps
  PairBuffer outside_pairs_;
  PairParts parts_;
};

}  // namespace sweepstake
