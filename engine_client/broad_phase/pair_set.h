// A set of overlap pairs that changes pair by pair: an array of them and an open-addressing index
// into it.
//
// Not thread-safe. Owns its memory, which only grows. Cost: Insert and Erase O(1) expected, Clear
// O(capacity). Memory: 8 bytes per pair + 8 to 16 of index. The order of pairs() follows from the
// history of calls alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/aligned_buffer.h"
#include "sweepstake/aabb.h"

namespace sweepstake {

class PairSet {
 public:
  void Clear();
  // Room for `count` pairs without another allocation.
  void Reserve(size_t count);

  // Both say whether the set changed.
  bool Insert(OverlapPair pair);
  bool Erase(OverlapPair pair);

  size_t size() const { return size_; }
  std::span<const OverlapPair> pairs() const { return {pairs_.data(), size_}; }
  size_t native_bytes() const { return pairs_.capacity_bytes() + slots_.capacity_bytes(); }

 private:
  size_t Home(OverlapPair pair) const;
  size_t SlotOf(OverlapPair pair) const;
  void CloseGap(size_t gap);
  void Rebuild(size_t slot_count);

  AlignedBuffer<OverlapPair> pairs_;
  AlignedBuffer<uint32_t>
      slots_;  // index into pairs_, or kEmpty; linear probing, at most half full
  size_t size_ = 0;
  size_t slot_count_ = 0;  // 0 or a power of two
};

}  // namespace sweepstake
