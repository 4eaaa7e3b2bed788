#include "engine_client/broad_phase/sorted_endpoints.h"

namespace sweepstake {

void SortedEndpoints::Reset(size_t box_count) {
  count_ = 2 * box_count;
  endpoints_.EnsureDiscarding(count_);
  for (size_t i = 0; i < box_count; ++i) {
    const auto owner = static_cast<uint32_t>(i);
    endpoints_[2 * i] = PackSortItem(0, owner);
    endpoints_[2 * i + 1] = PackSortItem(0, owner | kUpperFace);
  }
}

size_t SortedEndpoints::Refresh(std::span<const BoxKeys> boxes, int axis) {
  size_t descents = 0;
  uint64_t previous = 0;
  for (size_t i = 0; i < count_; ++i) {
    const uint64_t old = endpoints_[i];
    const size_t face = static_cast<size_t>(axis) + (IsUpperFace(old) ? 3 : 0);
    const uint64_t endpoint =
        PackSortItem(boxes[EndpointOwner(old)].face[face], SortItemPayload(old));
    endpoints_[i] = endpoint;
    descents += SortItemRank(previous) > SortItemRank(endpoint) ? 1 : 0;
    previous = endpoint;
  }
  return descents;
}

}  // namespace sweepstake
