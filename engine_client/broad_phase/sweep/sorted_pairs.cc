#include "engine_client/broad_phase/sweep/sorted_pairs.h"

#include <utility>

#include "engine_client/broad_phase/common/stop_poll.h"

namespace sweepstake {

// Sorts by a in one pass, then by b inside each group.
void SortedPairs::Adopt(std::span<const OverlapPair> pairs, size_t box_count, StopRequest* stop) {
  constexpr size_t kBoxesPerQuestion = 4096;
  count_ = pairs.size();
  touched_count_ = 0;
  // Reserves some more, so that a few more pairs in each frame do not allocate.
  pairs_.EnsureDiscarding(count_ + count_ / 8 + 64);
  starts_.EnsureDiscarding(box_count + 1);
  std::fill_n(starts_.data(), box_count + 1, 0U);
  for (const OverlapPair pair : pairs) ++starts_[pair.a];
  uint32_t sum = 0;
  for (size_t box = 0; box < box_count; ++box) sum += std::exchange(starts_[box], sum);
  for (const OverlapPair pair : pairs) pairs_[starts_[pair.a]++] = pair;
  size_t begin = 0;
  for (size_t box = 0; box < box_count; ++box) {
    if (box % kBoxesPerQuestion == 0 && IsStopped(stop)) return;
    std::sort(pairs_.data() + begin, pairs_.data() + starts_[box]);
    begin = starts_[box];
  }
}

void SortedPairs::Truncate(size_t count) {
  const auto end = std::remove_if(pairs_.data(), pairs_.data() + count_,
                                  [&](OverlapPair pair) { return pair.b >= count; });
  count_ = static_cast<size_t>(end - pairs_.data());
  touched_count_ = 0;
}

size_t SortedPairs::UniqueTouched() {
  std::sort(touched_.data(), touched_.data() + touched_count_);
  const auto end = std::unique(touched_.data(), touched_.data() + touched_count_);
  return static_cast<size_t>(end - touched_.data());
}

// Drop and Insert move the blocks between the given pairs. REQUIRES: these are in ascending order.
void SortedPairs::Drop(std::span<const OverlapPair> dropped) {
  OverlapPair* const end = pairs_.data() + count_;
  OverlapPair* to = nullptr;
  OverlapPair* from = pairs_.data();
  for (const OverlapPair pair : dropped) {
    OverlapPair* const place = std::lower_bound(from, end, pair);
    to = to == nullptr ? place : std::copy(from, place, to);
    from = place + 1;
  }
  if (to != nullptr) std::copy(from, end, to);
  count_ -= dropped.size();
}

void SortedPairs::Insert(std::span<const OverlapPair> inserted) {
  if (inserted.empty()) return;
  pairs_.EnsureKeeping(count_ + inserted.size(), count_);
  OverlapPair* const begin = pairs_.data();
  OverlapPair* end = begin + count_;
  for (size_t left = inserted.size(); left > 0; --left) {
    OverlapPair* const place = std::lower_bound(begin, end, inserted[left - 1]);
    std::copy_backward(place, end, end + left);
    place[left - 1] = inserted[left - 1];
    end = place;
  }
  count_ += inserted.size();
}

}  // namespace sweepstake
