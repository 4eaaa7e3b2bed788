#include "engine_client/broad_phase/common/radix_sort.h"

#include <algorithm>
#include <utility>

#include "engine_client/broad_phase/common/stop_poll.h"

namespace sweepstake {
namespace {

// Up to this count, clearing and summing the buckets costs more than an insertion sort.
constexpr size_t kInsertionLimit = 64;

size_t Digit(uint64_t item, size_t pass) { return (item >> (31 + 11 * pass)) & 2047; }

void InsertionSort(std::span<uint64_t> items) {
  for (size_t i = 1; i < items.size(); ++i) {
    const uint64_t item = items[i];
    size_t hole = i;
    for (; hole > 0 && SortItemRank(items[hole - 1]) > SortItemRank(item); --hole)
      items[hole] = items[hole - 1];
    items[hole] = item;
  }
}

}  // namespace

std::span<uint64_t> RadixSort::Items(size_t count) {
  count_ = count;
  items_.EnsureDiscarding(count);
  return {items_.data(), count};
}

std::span<const uint64_t> RadixSort::Sort(StopRequest* stop) {
  Sort(items_, count_, stop);
  return {items_.data(), count_};
}

void RadixSort::Sort(AlignedBuffer<uint64_t>& items, size_t count, StopRequest* stop) {
  if (count <= kInsertionLimit) {
    InsertionSort({items.data(), count});
    return;
  }
  spare_.EnsureDiscarding(count);
  if (!CountDigits(items.data(), count, stop)) return;
  for (size_t pass = 0; pass < kPasses; ++pass) {
    if (!Scatter(pass, items, count, stop)) return;
  }
}

// Counts all digits of the items. Like Scatter, returns false if `stop` ended the sort.
bool RadixSort::CountDigits(const uint64_t* items, size_t count, StopRequest* stop) {
  starts_.EnsureDiscarding(kPasses * kBuckets);
  std::fill_n(starts_.data(), kPasses * kBuckets, 0U);
  uint32_t* const low = starts_.data();
  uint32_t* const middle = low + kBuckets;
  uint32_t* const high = middle + kBuckets;
  return ForEachBlock(stop, 0, count, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      ++low[Digit(items[i], 0)];
      ++middle[Digit(items[i], 1)];
      ++high[Digit(items[i], 2)];
    }
  });
}

bool RadixSort::Scatter(size_t pass, AlignedBuffer<uint64_t>& items, size_t count,
                        StopRequest* stop) {
  uint32_t* const starts = starts_.data() + pass * kBuckets;
  const uint64_t* const from = items.data();
  if (starts[Digit(from[0], pass)] == count) return true;  // all items are in one bucket
  uint32_t sum = 0;
  for (size_t bucket = 0; bucket < kBuckets; ++bucket) sum += std::exchange(starts[bucket], sum);
  uint64_t* const to = spare_.data();
  const bool is_done = ForEachBlock(stop, 0, count, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) to[starts[Digit(from[i], pass)]++] = from[i];
  });
  if (is_done) std::swap(items, spare_);
  return is_done;
}

}  // namespace sweepstake
