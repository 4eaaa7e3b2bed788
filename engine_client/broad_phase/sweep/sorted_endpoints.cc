#include "engine_client/broad_phase/sweep/sorted_endpoints.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace sweepstake {
namespace {

// If a face shares its step with more faces than this on average, an exact sort is cheaper, since a
// sweep by steps then compares more registers.
constexpr uint64_t kMaxFacesSharingStep = 16;

uint64_t ItemOf(float coordinate, Endpoint endpoint) {
  return PackSortItem(SortableKey(coordinate), endpoint);
}

}  // namespace

void SortedEndpoints::Sort(std::span<const BoxRecord> records, const SweepAxis& steps,
                           EndpointRoom& room, StopRequest* stop) {
  count_ = 2 * records.size();
  endpoints_.EnsureDiscarding(count_);
  is_exact_ = !CountSteps(records, steps, room, stop);
  if (IsStopped(stop)) return;
  is_exact_ ? SortExactly(records, room, stop) : SortBySteps(records, steps, room, stop);
}

// Counts the faces of each step. Returns false if too many faces share a step.
bool SortedEndpoints::CountSteps(std::span<const BoxRecord> records, const SweepAxis& steps,
                                 EndpointRoom& room, StopRequest* stop) {
  const SweepAxis step = steps;  // a copy that no store can alias
  const auto step_count = static_cast<size_t>(step.last) + 1;
  room.starts.EnsureDiscarding(step_count);
  uint32_t* const starts = room.starts.data();
  std::fill_n(starts, step_count, 0U);
  uint64_t neighbours = 0;  // the number of pairs of faces that share a step
  ForEachBlock(stop, 0, records.size(), [&](size_t begin, size_t end) {
    uint64_t sum = 0;
    for (const BoxRecord& record : records.subspan(begin, end - begin)) {
      sum += starts[step.Step(record.min[axis_])]++;
      sum += starts[step.Step(record.max[axis_])]++;
    }
    neighbours += sum;
  });
  return neighbours <= kMaxFacesSharingStep * count_;
}

// Sorts the faces by step. REQUIRES: room.starts holds the counts of CountSteps.
void SortedEndpoints::SortBySteps(std::span<const BoxRecord> records, const SweepAxis& steps,
                                  EndpointRoom& room, StopRequest* stop) {
  const SweepAxis step = steps;  // a copy that no store can alias
  uint32_t* const starts = room.starts.data();
  const auto step_count = static_cast<size_t>(step.last) + 1;
  uint32_t sum = 0;
  for (size_t k = 0; k < step_count; ++k) sum += std::exchange(starts[k], sum);
  Endpoint* const order = endpoints_.data();
  ForEachBlock(stop, 0, records.size(), [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const auto owner = static_cast<Endpoint>(i);
      order[starts[step.Step(records[i].min[axis_])]++] = owner;
      order[starts[step.Step(records[i].max[axis_])]++] = owner | kUpperFace;
    }
  });
}

void SortedEndpoints::SortExactly(std::span<const BoxRecord> records, EndpointRoom& room,
                                  StopRequest* stop) {
  room.items.EnsureDiscarding(count_);
  const bool is_loaded = ForEachBlock(stop, 0, records.size(), [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const auto owner = static_cast<Endpoint>(i);
      room.items[2 * i] = ItemOf(records[i].min[axis_], owner);
      room.items[2 * i + 1] = ItemOf(records[i].max[axis_], owner | kUpperFace);
    }
  });
  if (!is_loaded) return;
  room.radix.Sort(room.items, count_, stop);
  std::transform(room.items.data(), room.items.data() + count_, endpoints_.data(), SortItemPayload);
}

void SortedEndpoints::StoreRanks(std::span<const BoxRecord> records, EndpointRoom& room) const {
  room.items.EnsureDiscarding(2 * records.size());
  uint64_t* const ranks = room.items.data();
  for (size_t i = 0; i < records.size(); ++i) {
    ranks[2 * i] = SortItemRank(ItemOf(records[i].min[axis_], 0));
    ranks[2 * i + 1] = SortItemRank(ItemOf(records[i].max[axis_], kUpperFace));
  }
}

void SortedEndpoints::Append(std::span<const BoxRecord> records, size_t first, EndpointRoom& room) {
  const size_t added = 2 * (records.size() - first);
  room.items.EnsureDiscarding(added);
  for (size_t i = first; i < records.size(); ++i) {
    const auto owner = static_cast<Endpoint>(i);
    room.items[2 * (i - first)] = ItemOf(records[i].min[axis_], owner);
    room.items[2 * (i - first) + 1] = ItemOf(records[i].max[axis_], owner | kUpperFace);
  }
  std::sort(room.items.data(), room.items.data() + added);
  endpoints_.EnsureKeeping(count_ + added, count_);
  Endpoint* const order = endpoints_.data();
  size_t end = count_;  // the end of the faces that are still at their old positions
  for (size_t left = added; left > 0; --left) {
    const uint64_t item = room.items[left - 1];
    const auto place =
        std::upper_bound(order, order + end, SortItemRank(item),
                         [&](uint64_t rank, Endpoint face) { return rank < Rank(records, face); });
    std::copy_backward(place, order + end, order + end + left);
    end = static_cast<size_t>(place - order);
    order[end + left - 1] = SortItemPayload(item);
  }
  count_ += added;
}

void SortedEndpoints::Truncate(size_t count) {
  const auto end = std::remove_if(endpoints_.data(), endpoints_.data() + count_,
                                  [&](Endpoint face) { return EndpointOwner(face) >= count; });
  count_ = static_cast<size_t>(end - endpoints_.data());
}

double SortedEndpoints::Density(std::span<const BoxRecord> records) const {
  if (count_ < 4) return 0;
  const double low = Coordinate(records, endpoints_[count_ / 4]);
  const double high = Coordinate(records, endpoints_[count_ / 4 * 3]);
  return static_cast<double>(count_) / 2 / std::max(high - low, 1e-30);
}

}  // namespace sweepstake
