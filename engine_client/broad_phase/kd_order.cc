#include "engine_client/broad_phase/kd_order.h"

#include <algorithm>
#include <array>

namespace sweepstake {
namespace {

struct Range {
  size_t begin;
  size_t end;
};

// Each split leaves at most 15/16 of a range, and the larger side waits: more than the depth that
// allows.
constexpr size_t kStackSize = 512;

// Strictly inside the range; see KdOrder::kPart.
size_t SplitPoint(const Range& range) {
  const size_t count = range.end - range.begin;
  size_t block = KdOrder::kPart;
  while (block * 16 < count) block *= 16;
  const size_t nearest = (count / 2 + block / 2) / block * block;
  return range.begin + std::clamp(nearest, block, (count - 1) / block * block);
}

}  // namespace

size_t KdOrder::CollectCenters(std::span<const Aabb> boxes, std::span<const uint32_t> order) {
  size_t front = 0;
  size_t back = order.size();
  for (const uint32_t index : order) {
    const Aabb& box = boxes[index];
    if (!TakesPart(box)) {
      centers_[--back] = {{}, index};
      continue;
    }
    Center& center = centers_[front++];
    center.box = index;
    // Halves: the sum of two finite floats need not be finite.
    for (int axis = 0; axis < 3; ++axis) {
      center.at[axis] = box.min[axis] * 0.5F + box.max[axis] * 0.5F;
    }
  }
  return front;
}

int KdOrder::WidestAxis(size_t begin, size_t end) const {
  Center low = centers_[begin];
  Center high = low;
  for (size_t i = begin + 1; i < end; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      low.at[axis] = std::min(low.at[axis], centers_[i].at[axis]);
      high.at[axis] = std::max(high.at[axis], centers_[i].at[axis]);
    }
  }
  int widest = 0;
  float extent = high.at[0] * 0.5F - low.at[0] * 0.5F;
  for (int axis = 1; axis < 3; ++axis) {
    const float other = high.at[axis] * 0.5F - low.at[axis] * 0.5F;
    if (other <= extent) continue;
    widest = axis;
    extent = other;
  }
  return widest;
}

void KdOrder::Split(size_t begin, size_t middle, size_t end) {
  const int axis = WidestAxis(begin, end);
  Center* const centers = centers_.data();
  std::nth_element(centers + begin, centers + middle, centers + end,
                   [axis](const Center& a, const Center& b) { return a.at[axis] < b.at[axis]; });
}

void KdOrder::SplitAll(size_t count) {
  std::array<Range, kStackSize> stack;
  size_t waiting = 0;
  stack[waiting++] = {0, count};
  while (waiting > 0) {
    const Range range = stack[--waiting];
    if (range.end - range.begin <= kPart) continue;
    const size_t middle = SplitPoint(range);
    Split(range.begin, middle, range.end);
    stack[waiting++] = {range.begin, middle};
    stack[waiting++] = {middle, range.end};
  }
}

void KdOrder::Sort(std::span<const Aabb> boxes, std::span<uint32_t> order) {
  centers_.EnsureDiscarding(order.size());
  SplitAll(CollectCenters(boxes, order));
  for (size_t i = 0; i < order.size(); ++i) order[i] = centers_[i].box;
}

}  // namespace sweepstake
