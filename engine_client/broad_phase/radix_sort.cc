#include "engine_client/broad_phase/radix_sort.h"

#include <algorithm>
#include <utility>

namespace sweepstake {
namespace {

// Below this clearing and summing the buckets costs more than moving items one by one.
constexpr size_t kInsertionLimit = 64;

size_t Digit(uint64_t item, size_t pass) { return (item >> (32 + 11 * pass)) & 2047; }

void InsertionSort(std::span<uint64_t> items) {
  for (size_t i = 1; i < items.size(); ++i) {
    const uint64_t item = items[i];
    size_t hole = i;
    for (; hole > 0 && SortItemKey(items[hole - 1]) > SortItemKey(item); --hole)
      items[hole] = items[hole - 1];
    items[hole] = item;
  }
}

}  // namespace

std::span<uint64_t> RadixSort::Items(size_t count) {
  count_ = count;
  items_.EnsureDiscarding(count);
  spare_.EnsureDiscarding(count);
  return {items_.data(), count};
}

std::span<const uint64_t> RadixSort::Sort() {
  if (count_ <= kInsertionLimit) {
    InsertionSort({items_.data(), count_});
    return {items_.data(), count_};
  }
  CountDigits();
  for (size_t pass = 0; pass < kPasses; ++pass) Scatter(pass);
  return {items_.data(), count_};
}

void RadixSort::CountDigits() {
  starts_.EnsureDiscarding(kPasses * kBuckets);
  std::fill_n(starts_.data(), kPasses * kBuckets, 0U);
  uint32_t* const low = starts_.data();
  uint32_t* const middle = low + kBuckets;
  uint32_t* const high = middle + kBuckets;
  for (size_t i = 0; i < count_; ++i) {
    ++low[Digit(items_[i], 0)];
    ++middle[Digit(items_[i], 1)];
    ++high[Digit(items_[i], 2)];
  }
}

void RadixSort::Scatter(size_t pass) {
  uint32_t* const starts = starts_.data() + pass * kBuckets;
  if (starts[Digit(items_[0], pass)] == count_) return;  // one bucket holds all: the order stands
  uint32_t sum = 0;
  for (size_t bucket = 0; bucket < kBuckets; ++bucket) sum += std::exchange(starts[bucket], sum);
  const uint64_t* const from = items_.data();
  uint64_t* const to = spare_.data();
  for (size_t i = 0; i < count_; ++i) to[starts[Digit(from[i], pass)]++] = from[i];
  std::swap(items_, spare_);
}

}  // namespace sweepstake
