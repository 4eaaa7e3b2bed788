// Counts the invalid boxes of a scene (aabb.h). They overlap nothing, which a game could otherwise
// notice only by objects that fall through one another. Empty boxes are not counted.
//
// Reading every box in every frame would cost more than 1 % of a fast search. So all boxes are read
// only in frames that build, and in a frame that removes objects while invalid boxes are known.
// Boxes that were added are read at once. Of the others, each frame reads the next
// 1/kFramesPerPass, but at least kMinBoxesPerFrame. A box that becomes invalid later is counted
// within kFramesPerPass frames, and one that becomes valid within twice that.
//
// Not thread-safe. Allocates nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "sweepstake/aabb.h"

namespace sweepstake {

class InvalidBoxCounter {
 public:
  static constexpr size_t kFramesPerPass = 256;
  static constexpr size_t kMinBoxesPerFrame = 4;

  // Reads all boxes.
  void CountAll(std::span<const Aabb> boxes);
  // Reads the boxes that were added since the previous call, and the next ones in turn.
  void Follow(std::span<const Aabb> boxes);

  uint32_t count() const { return count_; }

 private:
  // The invalid boxes of the latest complete pass over all boxes, those added since, and those of
  // the pass in progress if they are more.
  uint32_t count_ = 0;
  uint32_t pass_count_ = 0;  // the invalid boxes of the pass in progress
  size_t next_ = 0;          // the first box that this pass has not read
  size_t box_count_ = 0;     // the number of boxes at the previous call
};

}  // namespace sweepstake
