// The lower and upper faces of all boxes on one axis, kept in order from frame to frame.
//
// Not thread-safe. Owns its memory: 16 bytes per box. Equal coordinates order lower faces before
// upper ones, so that touching boxes overlap in this order too.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/aligned_buffer.h"
#include "engine_client/broad_phase/radix_sort.h"

namespace sweepstake {

// A sort item: the face's coordinate as a sortable key, and whose face it is.
constexpr uint32_t kUpperFace = 0x80000000;
constexpr uint32_t EndpointOwner(uint64_t endpoint) {
  return SortItemPayload(endpoint) & ~kUpperFace;
}
constexpr bool IsUpperFace(uint64_t endpoint) {
  return (SortItemPayload(endpoint) & kUpperFace) != 0;
}

// The faces of one box as sortable keys, in the order of Aabb. Integers compare as the floats do.
struct BoxKeys {
  uint32_t face[6];  // min x y z, max x y z
};

class SortedEndpoints {
 public:
  // Both faces of `box_count` boxes, in no particular order.
  void Reset(size_t box_count);
  // Takes the coordinates on `axis` and keeps the order; returns how many neighbours are now out of
  // order. O(n). REQUIRES: as many boxes as at the last Reset.
  size_t Refresh(std::span<const BoxKeys> boxes, int axis);
  // O(n), whatever the disorder.
  void Resort(RadixSort& sort) { sort.Sort(endpoints_, count_); }

  // Sorts by insertion and calls on_pass(stayed, moved) for each endpoint `stayed` that `moved`
  // passes on its way down: exactly the couples whose order changed. O(n + passes). Stops early, in
  // no particular order, and returns false when on_pass calls exceed `budget`, which is reduced by
  // those made.
  template <typename OnPass>
  bool Repair(size_t& budget, OnPass&& on_pass);

  std::span<const uint64_t> endpoints() const { return {endpoints_.data(), count_}; }
  size_t native_bytes() const { return endpoints_.capacity_bytes(); }

 private:
  AlignedBuffer<uint64_t> endpoints_;
  size_t count_ = 0;
};

template <typename OnPass>
bool SortedEndpoints::Repair(size_t& budget, OnPass&& on_pass) {
  for (size_t i = 1; i < count_; ++i) {
    const uint64_t moved = endpoints_[i];
    size_t hole = i;
    for (; hole > 0 && SortItemRank(endpoints_[hole - 1]) > SortItemRank(moved); --hole) {
      endpoints_[hole] = endpoints_[hole - 1];
      on_pass(endpoints_[hole], moved);
    }
    endpoints_[hole] = moved;
    if (i - hole > budget) return false;
    budget -= i - hole;
  }
  return true;
}

}  // namespace sweepstake
