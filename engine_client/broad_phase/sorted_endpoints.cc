#include "engine_client/broad_phase/sorted_endpoints.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace sweepstake {
namespace {

// Faces that share a step, in the mean over faces, from which on three passes are faster than
// insertion.
constexpr uint64_t kCrowd = 16;

// Lower face of `record` on an axis, or upper one.
uint64_t ItemOf(float coordinate, Endpoint endpoint) {
  return PackSortItem(SortableKey(coordinate), endpoint);
}

}  // namespace

void SortedEndpoints::Sort(std::span<const BoxRecord> records, float low, float high,
                           EndpointRoom& room) {
  count_ = 2 * records.size();
  endpoints_.EnsureDiscarding(count_);
  room.items.EnsureDiscarding(count_);
  if (SortBySteps(records, low, high, room)) return;
  for (size_t i = 0; i < records.size(); ++i) {
    const auto owner = static_cast<Endpoint>(i);
    room.items[2 * i] = ItemOf(records[i].min[axis_], owner);
    room.items[2 * i + 1] = ItemOf(records[i].max[axis_], owner | kUpperFace);
  }
  room.radix.Sort(room.items, count_);
  TakeOrder({room.items.data(), count_});
}

// False where the boxes are too crowded for that.
bool SortedEndpoints::SortBySteps(std::span<const BoxRecord> records, float low, float high,
                                  EndpointRoom& room) {
  const size_t step_count = std::clamp<size_t>(count_, 64, 65536);
  const float last = static_cast<float>(step_count) - 1;
  const float scale = static_cast<float>(step_count) / std::max(high - low, 1e-30F);
  const auto step_of = [&](float x) {
    return static_cast<uint32_t>(std::min(std::max((x - low) * scale, 0.0F), last));
  };
  room.starts.EnsureDiscarding(step_count);
  uint32_t* const starts = room.starts.data();
  std::fill_n(starts, step_count, 0U);
  for (const BoxRecord& record : records) {
    ++starts[step_of(record.min[axis_])];
    ++starts[step_of(record.max[axis_])];
  }
  uint64_t neighbours = 0;
  uint32_t sum = 0;
  for (size_t step = 0; step < step_count; ++step) {
    neighbours += uint64_t{starts[step]} * starts[step];
    sum += std::exchange(starts[step], sum);
  }
  if (neighbours > kCrowd * count_) return false;
  uint64_t* const items = room.items.data();
  for (size_t i = 0; i < records.size(); ++i) {
    const auto owner = static_cast<Endpoint>(i);
    const float min = records[i].min[axis_];
    const float max = records[i].max[axis_];
    items[starts[step_of(min)]++] = ItemOf(min, owner);
    items[starts[step_of(max)]++] = ItemOf(max, owner | kUpperFace);
  }
  for (size_t i = 1; i < count_; ++i) {
    const uint64_t item = items[i];
    size_t hole = i;
    for (; hole > 0 && items[hole - 1] > item; --hole) items[hole] = items[hole - 1];
    items[hole] = item;
  }
  TakeOrder({items, count_});
  return true;
}

void SortedEndpoints::TakeOrder(std::span<const uint64_t> items) {
  std::transform(items.begin(), items.end(), endpoints_.data(), SortItemPayload);
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
  size_t end = count_;  // of the faces that are not yet behind an added one
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
