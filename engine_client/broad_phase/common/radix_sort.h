// Sorts boxes by one float each, in three passes of 11 bits, least significant first, with reused
// buffers.
//
// Not thread-safe. Owns its memory. Cost: O(n). Memory: 16 bytes per item + 24 KiB.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/common/aligned_buffer.h"
#include "sweepstake/broad_phase.h"

namespace sweepstake {

// Returns an unsigned key in the order of the floats; −0 and +0 have the same key. REQUIRES:
// `value` is not NaN.
inline uint32_t SortableKey(float value) {
  const uint32_t bits = std::bit_cast<uint32_t>(value + 0.0F);  // −0 + 0 = +0
  return bits ^ ((bits >> 31) != 0 ? 0xFFFFFFFFU : 0x80000000U);
}

// Packs a key and its payload into one word. Items are ordered by 33 bits, which three passes of 11
// bits cover: the key, and the highest bit of the payload to break ties.
constexpr uint64_t PackSortItem(uint32_t key, uint32_t payload) {
  return uint64_t{key} << 32 | payload;
}
constexpr uint32_t SortItemPayload(uint64_t item) { return static_cast<uint32_t>(item); }
// Returns the 33 bits that define the order.
constexpr uint64_t SortItemRank(uint64_t item) { return item >> 31; }

class RadixSort {
 public:
  // Returns an array of `count` items, which the caller fills with PackSortItem. It is valid until
  // the next call of Items or Sort.
  std::span<uint64_t> Items(size_t count);
  // Sorts the array of the latest call of Items. Items of equal rank keep their order. The result
  // is valid until the next call of Items or Sort. Polls `stop`, which may be null; after a stop
  // the items are undefined.
  std::span<const uint64_t> Sort(StopRequest* stop = nullptr);
  // Sorts the first `count` elements of `items`. May swap the storage of `items` with a buffer of
  // this sorter, to avoid copying the result.
  void Sort(AlignedBuffer<uint64_t>& items, size_t count, StopRequest* stop = nullptr);

  size_t native_bytes() const {
    return items_.capacity_bytes() + spare_.capacity_bytes() + starts_.capacity_bytes();
  }

 private:
  static constexpr size_t kPasses = 3;
  static constexpr size_t kBuckets = 2048;

  bool CountDigits(const uint64_t* items, size_t count, StopRequest* stop);
  bool Scatter(size_t pass, AlignedBuffer<uint64_t>& items, size_t count, StopRequest* stop);

  AlignedBuffer<uint64_t> items_;
  AlignedBuffer<uint64_t> spare_;
  AlignedBuffer<uint32_t> starts_;  // the first slots of kPasses × kBuckets buckets
  size_t count_ = 0;
};

}  // namespace sweepstake
