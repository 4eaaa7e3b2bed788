// The lower and upper faces of all boxes on one axis, kept sorted from frame to frame.
//
// Not thread-safe; distinct axes are independent. Owns its memory: 8 bytes per box. A face is
// stored as the box's id and a bit; its coordinate is read from the records (box_record.h). At
// equal coordinates lower faces come before upper ones, so that touching boxes overlap in this
// order too.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/common/aligned_buffer.h"
#include "engine_client/broad_phase/common/box_record.h"
#include "engine_client/broad_phase/common/byte_boxes.h"
#include "engine_client/broad_phase/common/radix_sort.h"
#include "engine_client/broad_phase/common/stop_poll.h"

namespace sweepstake {

// A face: the box's id, and a bit for the upper face.
using Endpoint = uint32_t;
inline constexpr Endpoint kUpperFace = 0x80000000;
constexpr uint32_t EndpointOwner(Endpoint endpoint) { return endpoint & ~kUpperFace; }
constexpr bool IsUpperFace(Endpoint endpoint) { return (endpoint & kUpperFace) != 0; }

// The number of swaps that repairs may still make.
class SwapAllowance {
 public:
  // `stop` may be null. It is polled about once per millisecond of swaps.
  explicit SwapAllowance(size_t swaps, StopRequest* stop = nullptr)
      : stop_(stop), reserve_(swaps) {}

  // Subtracts `swaps`. Returns false if fewer are left, or if the repair must stop.
  bool Spend(size_t swaps) {
    if (swaps > portion_ && !Refill(swaps)) return false;
    portion_ -= swaps;
    return true;
  }
  size_t left() const { return reserve_ + portion_; }

 private:
  static constexpr size_t kSwapsPerQuestion = size_t{1} << 18;

  bool Refill(size_t swaps) {
    if (swaps > left() || IsStopped(stop_)) return false;
    const size_t all = left();
    portion_ = std::min(all, std::max(swaps, kSwapsPerQuestion));
    reserve_ = all - portion_;
    return true;
  }

  StopRequest* stop_;
  size_t reserve_;
  size_t portion_ = 0;  // swaps until the next poll
};

// Buffers for sorting, kept for reuse. Memory: 16 bytes per box and up to 256 KiB, and 16 more
// bytes per box for an exact sort.
class EndpointRoom {
 public:
  size_t native_bytes() const {
    return items.capacity_bytes() + starts.capacity_bytes() + radix.native_bytes();
  }

  // Holds either sort items (radix_sort.h) whose payload is an endpoint, or the ranks of all
  // endpoints.
  AlignedBuffer<uint64_t> items;
  AlignedBuffer<uint32_t> starts;
  RadixSort radix;
};

// The set of boxes that have moved since the orders were last sorted or repaired.
class MovedBoxes {
 public:
  // Empties the set and makes room for `box_count` boxes.
  void Clear(size_t box_count) {
    words_.EnsureDiscarding(box_count / 64 + 1);
    std::fill_n(words_.data(), box_count / 64 + 1, uint64_t{0});
    count_ = 0;
  }
  // REQUIRES: the box has not been added since Clear.
  void Add(size_t box) {
    words_[box / 64] |= uint64_t{1} << (box % 64);
    ++count_;
  }
  size_t count() const { return count_; }
  bool Has(size_t box) const { return (words_[box / 64] >> (box % 64) & 1) != 0; }
  size_t native_bytes() const { return words_.capacity_bytes(); }

 private:
  AlignedBuffer<uint64_t> words_;
  size_t count_ = 0;
};

class SortedEndpoints {
 public:
  explicit SortedEndpoints(size_t axis) : axis_(axis) {}

  // Sorts the faces of all `records`, O(n). `steps` divides the axis into equal intervals, the
  // steps. One pass sorts the faces by step; within a step they are in the order of their ids. A
  // sweep by the same steps still finds every pair, and Repair makes the order exact. If many faces
  // share a step, three passes sort all faces exactly instead. Polls `stop`, which may be null;
  // after a stop the order is undefined.
  void Sort(std::span<const BoxRecord> records, const SweepAxis& steps, EndpointRoom& room,
            StopRequest* stop = nullptr);
  // Returns whether the faces are sorted exactly, not only by steps (see Sort).
  bool is_exact() const { return is_exact_; }
  // Inserts the faces of the boxes from index `first` on, which should be few. A binary search
  // finds the position of each face, and the faces between two positions are moved together. An
  // exact order stays exact, and an order by steps stays an order by steps.
  void Append(std::span<const BoxRecord> records, size_t first, EndpointRoom& room);
  // Removes the faces of the boxes with index `count` or higher.
  void Truncate(size_t count);

  // Restores the exact order by insertion, after some boxes have moved or after a Sort by steps. If
  // a lower face of one box and an upper face of another have changed their order, calls on_swap(a,
  // b) for these boxes. O(n + swaps). Subtracts the swaps from `allowance`. Returns false if too
  // few are left or if stopped; the order is then incomplete and needs a Sort.
  template <typename OnSwap>
  bool Repair(std::span<const BoxRecord> records, const MovedBoxes& moved, EndpointRoom& room,
              SwapAllowance& allowance, OnSwap&& on_swap);

  std::span<const Endpoint> endpoints() const { return {endpoints_.data(), count_}; }
  // Returns the mean number of faces per unit of length, measured between the lower and the upper
  // quartile of the faces.
  double Density(std::span<const BoxRecord> records) const;
  size_t native_bytes() const { return endpoints_.capacity_bytes(); }

 private:
  float Coordinate(std::span<const BoxRecord> records, Endpoint endpoint) const {
    const BoxRecord& record = records[EndpointOwner(endpoint)];
    return IsUpperFace(endpoint) ? record.max[axis_] : record.min[axis_];
  }
  // Returns the integer by which the faces are sorted: the coordinate, and the upper-face bit for
  // equal coordinates.
  uint64_t Rank(std::span<const BoxRecord> records, Endpoint endpoint) const {
    return SortItemRank(PackSortItem(SortableKey(Coordinate(records, endpoint)), endpoint));
  }
  bool CountSteps(std::span<const BoxRecord> records, const SweepAxis& steps, EndpointRoom& room,
                  StopRequest* stop);
  void SortBySteps(std::span<const BoxRecord> records, const SweepAxis& steps, EndpointRoom& room,
                   StopRequest* stop);
  void SortExactly(std::span<const BoxRecord> records, EndpointRoom& room, StopRequest* stop);
  // Stores the ranks of all faces in room.items, by owner, the lower face before the upper one.
  void StoreRanks(std::span<const BoxRecord> records, EndpointRoom& room) const;
  template <typename RankOf, typename HasMoved, typename OnSwap>
  bool RepairBy(const RankOf& rank_of, const HasMoved& has_moved, SwapAllowance& allowance,
                OnSwap&& on_swap);

  size_t axis_;
  AlignedBuffer<Endpoint> endpoints_;
  size_t count_ = 0;
  bool is_exact_ = true;
};

template <typename OnSwap>
bool SortedEndpoints::Repair(std::span<const BoxRecord> records, const MovedBoxes& moved,
                             EndpointRoom& room, SwapAllowance& allowance, OnSwap&& on_swap) {
  if (is_exact_ && 8 * moved.count() < records.size()) {
    return RepairBy([&](Endpoint face) { return Rank(records, face); },
                    [&](Endpoint face) { return moved.Has(EndpointOwner(face)); }, allowance,
                    on_swap);
  }
  StoreRanks(records, room);
  const uint64_t* const ranks = room.items.data();
  return RepairBy([ranks](Endpoint face) { return ranks[std::rotl(face, 1)]; },
                  [](Endpoint) { return true; }, allowance, on_swap);
}

template <typename RankOf, typename HasMoved, typename OnSwap>
bool SortedEndpoints::RepairBy(const RankOf& rank_of, const HasMoved& has_moved,
                               SwapAllowance& allowance, OnSwap&& on_swap) {
  Endpoint* const order = endpoints_.data();
  is_exact_ = false;
  bool before_moved = false;  // whether the face before this one has moved
  bool before_known = false;  // whether before_rank is the rank of that face
  uint64_t before_rank = 0;
  for (size_t i = 0; i < count_; ++i) {
    const Endpoint face = order[i];
    // Skips a face that is in order, since neither it nor the face before it has moved.
    const bool moved = has_moved(face);
    if (!moved && !before_moved) {
      before_known = false;
      continue;
    }
    // Compares the face's rank with the rank of the face before it.
    const uint64_t rank = rank_of(face);
    if (!before_known) before_rank = i > 0 ? rank_of(order[i - 1]) : 0;
    before_known = true;
    if (before_rank <= rank) {
      before_rank = rank;
      before_moved = moved;
      continue;
    }
    // Moves this face down. The face with the maximum rank so far is then at i, and before_rank
    // stays its rank.
    size_t hole = i;
    do {
      const Endpoint swapped = order[--hole];
      order[hole + 1] = swapped;
      const uint32_t a = EndpointOwner(swapped);
      const uint32_t b = EndpointOwner(face);
      if (IsUpperFace(swapped) != IsUpperFace(face) && a != b) on_swap(a, b);
    } while (hole > 0 && rank_of(order[hole - 1]) > rank);
    order[hole] = face;
    before_moved = has_moved(order[i]);
    if (!allowance.Spend(i - hole)) return false;
  }
  is_exact_ = true;
  return true;
}

}  // namespace sweepstake
