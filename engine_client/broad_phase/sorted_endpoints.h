// The lower and upper faces of all boxes on one axis, kept in order from frame to frame.
//
// Not thread-safe; distinct axes are independent. Owns its memory: 8 bytes per box. Faces are named
// by the box's id and looked up in the records (box_record.h). Equal coordinates order lower faces
// before upper ones, so that touching boxes overlap in this order too.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/aligned_buffer.h"
#include "engine_client/broad_phase/box_record.h"
#include "engine_client/broad_phase/radix_sort.h"

namespace sweepstake {

// A face: whose it is, and which.
using Endpoint = uint32_t;
inline constexpr Endpoint kUpperFace = 0x80000000;
constexpr uint32_t EndpointOwner(Endpoint endpoint) { return endpoint & ~kUpperFace; }
constexpr bool IsUpperFace(Endpoint endpoint) { return (endpoint & kUpperFace) != 0; }

// What sorting needs, kept for reuse: 16 bytes per box and up to 256 KiB; twice 16 where the boxes
// are crowded.
class EndpointRoom {
 public:
  size_t native_bytes() const {
    return items.capacity_bytes() + starts.capacity_bytes() + radix.native_bytes();
  }

  AlignedBuffer<uint64_t> items;  // sort items (radix_sort.h) whose payload is an endpoint
  AlignedBuffer<uint32_t> starts;
  RadixSort radix;
};

// Which boxes have moved since the orders were made.
class MovedBoxes {
 public:
  // None of `count`.
  void Clear(size_t count) {
    words_.EnsureDiscarding(count / 64 + 1);
    std::fill_n(words_.data(), count / 64 + 1, uint64_t{0});
  }
  void Add(size_t box) { words_[box / 64] |= uint64_t{1} << (box % 64); }
  bool Has(size_t box) const { return (words_[box / 64] >> (box % 64) & 1) != 0; }
  size_t native_bytes() const { return words_.capacity_bytes(); }

 private:
  AlignedBuffer<uint64_t> words_;
};

class SortedEndpoints {
 public:
  explicit SortedEndpoints(size_t axis) : axis_(axis) {}

  // Takes the faces of all `records`. O(n): one pass by equal steps over [low, high], where most
  // boxes lie, and insertion inside the steps; three passes where boxes are crowded.
  void Sort(std::span<const BoxRecord> records, float low, float high, EndpointRoom& room);
  // Adds the faces of the boxes from `first` on, which are few: each is sought, the others are
  // moved as blocks. REQUIRES: the order of the others is right.
  void Append(std::span<const BoxRecord> records, size_t first, EndpointRoom& room);
  // Drops the faces of the boxes from `count` on.
  void Truncate(size_t count);

  // Puts the order right after some boxes have moved, by insertion, and calls on_pass(a, b) for
  // each lower face of one box and upper face of another whose order has changed. O(n + passes), at
  // a nanosecond for a face that stays. Gives up when the passes exceed `budget`, which is reduced
  // by those made: false, and the order is to be made anew by Sort.
  template <typename OnPass>
  bool Repair(std::span<const BoxRecord> records, const MovedBoxes& moved, size_t& budget,
              OnPass&& on_pass);

  std::span<const Endpoint> endpoints() const { return {endpoints_.data(), count_}; }
  // Faces per unit of length where the middle half of them lies.
  double Density(std::span<const BoxRecord> records) const;
  size_t native_bytes() const { return endpoints_.capacity_bytes(); }

 private:
  float Coordinate(std::span<const BoxRecord> records, Endpoint endpoint) const {
    const BoxRecord& record = records[EndpointOwner(endpoint)];
    return IsUpperFace(endpoint) ? record.max[axis_] : record.min[axis_];
  }
  // Orders faces as one number.
  uint64_t Rank(std::span<const BoxRecord> records, Endpoint endpoint) const {
    return SortItemRank(PackSortItem(SortableKey(Coordinate(records, endpoint)), endpoint));
  }
  bool SortBySteps(std::span<const BoxRecord> records, float low, float high, EndpointRoom& room);
  void TakeOrder(std::span<const uint64_t> items);

  size_t axis_;
  AlignedBuffer<Endpoint> endpoints_;
  size_t count_ = 0;
};

template <typename OnPass>
bool SortedEndpoints::Repair(std::span<const BoxRecord> records, const MovedBoxes& moved,
                             size_t& budget, OnPass&& on_pass) {
  Endpoint* const order = endpoints_.data();
  bool before_moved = false;  // the face before this one
  uint64_t before_rank = 0;   // of that face, where a face was looked up for it
  bool before_known = false;
  for (size_t i = 0; i < count_; ++i) {
    const Endpoint face = order[i];
    const bool face_moved = moved.Has(EndpointOwner(face));
    if (!face_moved && !before_moved) {
      before_known = false;
      continue;
    }
    const uint64_t rank = Rank(records, face);
    if (i > 0 && !before_known) before_rank = Rank(records, order[i - 1]);
    before_known = true;
    if (i == 0 || before_rank <= rank) {
      before_rank = rank;
      before_moved = face_moved;
      continue;
    }
    // The largest so far ends up here again: what is known of it stays.
    size_t hole = i;
    do {
      const Endpoint passed = order[--hole];
      order[hole + 1] = passed;
      const uint32_t a = EndpointOwner(passed);
      const uint32_t b = EndpointOwner(face);
      if (IsUpperFace(passed) != IsUpperFace(face) && a != b) on_pass(a, b);
    } while (hole > 0 && Rank(records, order[hole - 1]) > rank);
    order[hole] = face;
    before_moved = moved.Has(EndpointOwner(order[i]));
    if (i - hole > budget) return false;
    budget -= i - hole;
  }
  return true;
}

}  // namespace sweepstake
