#include "engine_client/broad_phase/common/coordinate_range.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "server/decision/math/hash.h"

namespace sweepstake {
namespace {

constexpr size_t kSampleCount = 128;
// A sample of 128 takes longer than half of what sorting 1,000 boxes does.
constexpr size_t kFewBoxes = 4096;
constexpr size_t kSmallSampleCount = 64;
// Of the sample on either side, outliers perhaps: one box at 1e30 must not make all others one.
constexpr size_t kTail = 2;
constexpr float kFarthestBound = 1e38F;  // the difference of two is finite

struct AxisSample {
  float low[kSampleCount] = {};
  float high[kSampleCount] = {};
  size_t count = 0;

  void Add(float from, float to) {
    low[count] = from;
    high[count++] = to;
  }
};

// The k-th draw without a period: objects often come in classes by index modulo something.
size_t DrawIndex(size_t k, size_t box_count) {
  const uint64_t fraction = (k * math::kGoldenGamma) >> 32;  // of 2^32, by the golden ratio
  return static_cast<size_t>((fraction * box_count) >> 32);
}

void SetBounds(AxisSample& sample, float& low, float& high) {
  const size_t tail = std::min(kTail, (sample.count - 1) / 2);
  std::nth_element(sample.low, sample.low + tail, sample.low + sample.count);
  const auto upper = sample.high + (sample.count - 1 - tail);
  std::nth_element(sample.high, upper, sample.high + sample.count);
  low = std::clamp(sample.low[tail], -kFarthestBound, kFarthestBound);
  high = std::clamp(*upper, -kFarthestBound, kFarthestBound);
  const float margin = std::max((high - low) / 16, CoordinateRange::kNarrowest);
  low = std::max(low - margin, -kFarthestBound);
  high = std::max(std::min(high + margin, kFarthestBound), low + CoordinateRange::kNarrowest);
}

// The mean part of `width` that a box takes up.
float MeanShare(const AxisSample& sample, float width) {
  float sum = 0;
  for (size_t k = 0; k < sample.count; ++k)
    sum += std::min(1.0F, (sample.high[k] - sample.low[k]) / width);
  return sum / static_cast<float>(sample.count);
}

// Points have no share: the wider of two axes is then the better.
int AxisOfLeastShare(const float (&share)[3], const CoordinateRange& range) {
  const float widest = std::max({range.width(0), range.width(1), range.width(2)});
  int best = 0;
  float best_cost = std::numeric_limits<float>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const float cost = share[axis] + 1e-5F * (widest / range.width(axis));
    if (cost >= best_cost) continue;
    best = axis;
    best_cost = cost;
  }
  return best;
}

}  // namespace

CoordinateRange CoordinateRange::Sample(std::span<const Aabb> boxes) {
  AxisSample samples[3];
  const size_t draws =
      std::min(boxes.size(), boxes.size() < kFewBoxes ? kSmallSampleCount : kSampleCount);
  for (size_t k = 0; k < draws; ++k) {
    const Aabb& box = boxes[draws == boxes.size() ? k : DrawIndex(k, boxes.size())];
    if (!TakesPart(box)) continue;
    for (int axis = 0; axis < 3; ++axis) samples[axis].Add(box.min[axis], box.max[axis]);
  }
  CoordinateRange range;
  if (samples[0].count == 0) return range;
  float share[3];
  for (int axis = 0; axis < 3; ++axis) {
    AxisSample bounds = samples[axis];  // whose order is lost
    SetBounds(bounds, range.low[axis], range.high[axis]);
    share[axis] = MeanShare(samples[axis], range.width(axis));
  }
  range.sweep_axis = AxisOfLeastShare(share, range);
  return range;
}

}  // namespace sweepstake
