// The overlapping pairs in ascending order, kept between frames and updated where they change.
//
// Not thread-safe. Owns its memory: 8 bytes per pair, and 8 per pair touched in one frame.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>

#include "engine_client/broad_phase/common/aligned_buffer.h"
#include "engine_client/broad_phase/common/stop_poll.h"
#include "sweepstake/aabb.h"
#include "sweepstake/broad_phase.h"

namespace sweepstake {

class SortedPairs {
 public:
  // Replaces the content by these pairs of `box_count` objects, each once, in any order. O(n +
  // pairs) if no object has very many pairs. Polls `stop`, which may be null; after a stop the
  // content is undefined.
  void Adopt(std::span<const OverlapPair> pairs, size_t box_count, StopRequest* stop = nullptr);
  // Removes the pairs of the objects from `count` on.
  void Truncate(size_t count);

  // Marks a pair that may have begun or ended, in any order and any number of times.
  void Touch(uint32_t a, uint32_t b) {
    if (touched_count_ == touched_.capacity())
      touched_.EnsureKeeping(std::max<size_t>(touched_count_ * 2, 64), touched_count_);
    touched_[touched_count_++] = {std::min(a, b), std::max(a, b)};
  }
  // Calls overlaps(a, b) for each pair marked since the last call of Settle, and adds or removes
  // that pair. Cost: O(log pairs) per marked pair, plus moving the pairs behind changed ones in
  // blocks. `stop` is as in Adopt.
  template <typename Overlaps>
  void Settle(Overlaps&& overlaps, StopRequest* stop = nullptr);
  // Removes the marks.
  void ClearTouched() { touched_count_ = 0; }

  std::span<const OverlapPair> pairs() const { return {pairs_.data(), count_}; }
  size_t native_bytes() const {
    return pairs_.capacity_bytes() + spare_.capacity_bytes() + touched_.capacity_bytes() +
           starts_.capacity_bytes();
  }

 private:
  void SortTo(OverlapPair* sorted, std::span<const OverlapPair> pairs, StopRequest* stop);
  size_t UniqueTouched(StopRequest* stop);
  void Drop(std::span<const OverlapPair> dropped);
  void Insert(std::span<const OverlapPair> inserted, StopRequest* stop);

  AlignedBuffer<OverlapPair> pairs_;
  AlignedBuffer<OverlapPair> spare_;
  AlignedBuffer<OverlapPair> touched_;
  AlignedBuffer<uint32_t> starts_;
  size_t box_count_ = 0;
  size_t count_ = 0;
  size_t touched_count_ = 0;
};

template <typename Overlaps>
void SortedPairs::Settle(Overlaps&& overlaps, StopRequest* stop) {
  const size_t count = UniqueTouched(stop);
  if (IsStopped(stop)) return;
  // Collects the pairs to insert at the front of `touched_` and the pairs to remove in `spare_`.
  OverlapPair* const touched = touched_.data();
  const OverlapPair* from = pairs_.data();
  size_t inserted = 0;
  size_t dropped = 0;
  spare_.EnsureDiscarding(count);
  const bool is_done = ForEachBlock(stop, 0, count, [&](size_t begin, size_t end) {
    for (size_t k = begin; k < end; ++k) {
      const OverlapPair pair = touched[k];
      from = std::lower_bound(from, static_cast<const OverlapPair*>(pairs_.data()) + count_, pair);
      const bool present = from != pairs_.data() + count_ && *from == pair;
      if (overlaps(pair.a, pair.b) == present) continue;
      if (present) {
        spare_[dropped++] = pair;
      } else {
        touched[inserted++] = pair;
      }
    }
  });
  if (!is_done) return;
  Drop({spare_.data(), dropped});
  Insert({touched, inserted}, stop);
  touched_count_ = 0;
}

}  // namespace sweepstake
