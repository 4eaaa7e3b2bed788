#include "engine_client/broad_phase/sweep/sorted_pairs.h"

#include <utility>

namespace sweepstake {

void SortedPairs::Adopt(std::span<const OverlapPair> pairs, size_t box_count, StopRequest* stop) {
  box_count_ = box_count;
  count_ = pairs.size();
  touched_count_ = 0;
  // Reserves spare room, so that a few more pairs in each frame do not allocate.
  pairs_.EnsureDiscarding(count_ + count_ / 8 + 64);
  SortTo(pairs_.data(), pairs, stop);
}

// Sorts the pairs by `a` in one counting pass, then by `b` among pairs with the same `a`.
void SortedPairs::SortTo(OverlapPair* sorted, std::span<const OverlapPair> pairs,
                         StopRequest* stop) {
  constexpr size_t kGroupsPerQuestion = 4096;
  starts_.EnsureDiscarding(box_count_ + 1);
  uint32_t* const starts = starts_.data();
  std::fill_n(starts, box_count_ + 1, 0U);
  const auto count = [&](size_t from, size_t to) {
    for (size_t k = from; k < to; ++k) ++starts[pairs[k].a];
  };
  if (!ForEachBlock(stop, 0, pairs.size(), count)) return;
  uint32_t sum = 0;
  for (size_t box = 0; box < box_count_; ++box) sum += std::exchange(starts[box], sum);
  const auto place = [&](size_t from, size_t to) {
    for (size_t k = from; k < to; ++k) sorted[starts[pairs[k].a]++] = pairs[k];
  };
  if (!ForEachBlock(stop, 0, pairs.size(), place)) return;
  size_t begin = 0;
  const auto sort_groups = [&](size_t from, size_t to) {
    for (size_t box = from; box < to; ++box) {
      std::sort(sorted + begin, sorted + starts[box]);
      begin = starts[box];
    }
  };
  ForEachBlock(stop, 0, box_count_, sort_groups, kGroupsPerQuestion);
}

void SortedPairs::Truncate(size_t count) {
  const auto end = std::remove_if(pairs_.data(), pairs_.data() + count_,
                                  [&](OverlapPair pair) { return pair.b >= count; });
  count_ = static_cast<size_t>(end - pairs_.data());
  touched_count_ = 0;
}

// Sorts the marked pairs and removes duplicates; returns the number left. Many marks are sorted by
// SortTo, which is faster and polls `stop`. For few marks, SortTo's pass over all boxes would cost
// too much.
size_t SortedPairs::UniqueTouched(StopRequest* stop) {
  constexpr size_t kBoxesPerMark = 8;
  if (touched_count_ > box_count_ / kBoxesPerMark) {
    spare_.EnsureDiscarding(touched_count_);
    SortTo(spare_.data(), {touched_.data(), touched_count_}, stop);
    std::swap(touched_, spare_);
  } else {
    std::sort(touched_.data(), touched_.data() + touched_count_);
  }
  const auto end = std::unique(touched_.data(), touched_.data() + touched_count_);
  return static_cast<size_t>(end - touched_.data());
}

// Removes these pairs. Like Insert, moves the pairs between them in whole blocks. REQUIRES, also in
// Insert: the given pairs are in ascending order.
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

void SortedPairs::Insert(std::span<const OverlapPair> inserted, StopRequest* stop) {
  if (inserted.empty()) return;
  pairs_.EnsureKeeping(count_ + inserted.size(), count_);
  OverlapPair* const begin = pairs_.data();
  OverlapPair* end = begin + count_;
  ForEachBlock(stop, 0, inserted.size(), [&](size_t from, size_t to) {
    for (size_t left = inserted.size() - from; left > inserted.size() - to; --left) {
      OverlapPair* const place = std::lower_bound(begin, end, inserted[left - 1]);
      std::copy_backward(place, end, end + left);
      place[left - 1] = inserted[left - 1];
      end = place;
    }
  });
  count_ += inserted.size();
}

}  // namespace sweepstake
