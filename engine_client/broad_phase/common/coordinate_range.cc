#include "engine_client/broad_phase/common/coordinate_range.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "engine_client/math/hash.h"

namespace sweepstake {
namespace {

constexpr size_t kSampleCount = 128;
// With fewer boxes than this, the sample has kSmallSampleCount boxes, since a sample of
// kSampleCount would cost as much as sorting the boxes.
constexpr size_t kFewBoxes = 4096;
constexpr size_t kSmallSampleCount = 64;
// The number of values at either end of the sample that are treated as outliers. Otherwise a single
// box at 1e30 would widen the range until all other boxes round to one value.
constexpr size_t kTail = 2;
constexpr float kMaxBound = 1e38F;  // so that the difference of two bounds is finite

struct AxisSample {
  float low[kSampleCount] = {};
  float high[kSampleCount] = {};
  size_t count = 0;

  void Add(float from, float to) {
    low[count] = from;
    high[count++] = to;
  }
};

void SetBounds(AxisSample& sample, float& low, float& high) {
  const size_t tail = std::min(kTail, (sample.count - 1) / 2);
  std::nth_element(sample.low, sample.low + tail, sample.low + sample.count);
  const auto upper = sample.high + (sample.count - 1 - tail);
  std::nth_element(sample.high, upper, sample.high + sample.count);
  low = std::clamp(sample.low[tail], -kMaxBound, kMaxBound);
  high = std::clamp(*upper, -kMaxBound, kMaxBound);
  const float margin = std::max((high - low) / 16, CoordinateRange::kMinWidth);
  low = std::max(low - margin, -kMaxBound);
  high = std::max(std::min(high + margin, kMaxBound), low + CoordinateRange::kMinWidth);
}

// Returns whether most boxes share a small part of the range, and more than kTail do not.
bool IsCrowded(const AxisSample& sample, float low, float width) {
  constexpr size_t kBuckets = 16;
  constexpr size_t kCrowdedBuckets = 4;  // all boxes crowd into this number of buckets or fewer
  const float scale = kBuckets / width;
  std::array<uint32_t, kBuckets> counts{};
  for (size_t k = 0; k < sample.count; ++k) {
    const float bucket = std::min(std::max((sample.low[k] - low) * scale, 0.0F), kBuckets - 1.0F);
    ++counts[static_cast<uint32_t>(bucket)];
  }
  size_t squares = 0;
  for (const uint32_t count : counts) squares += count * count;
  const uint32_t most = *std::max_element(counts.begin(), counts.end());
  return squares * kCrowdedBuckets > sample.count * sample.count && most + 2 * kTail < sample.count;
}

// Returns the function that spreads the sampled boxes evenly over [0, 1].
PiecewiseLine<CoordinateRange::kMaxSegments> SpreadEvenly(AxisSample sample) {
  // A straight line may miss the rank of a sampled coordinate by this fraction of the sample.
  constexpr float kMaxMissed = 1.0F / 64;
  for (float& low : sample.low) low = std::clamp(low, -kMaxBound, kMaxBound);
  std::sort(sample.low, sample.low + sample.count);
  const auto ranks = static_cast<float>(sample.count - 1);
  auto line = PiecewiseLine<CoordinateRange::kMaxSegments>::Fit({sample.low, sample.count},
                                                                kMaxMissed * ranks);
  for (float& scale : line.scale) scale /= ranks;
  for (float& rise : line.rise) rise /= ranks;
  return line;
}

// Returns the mean fraction of `width` that a box covers.
float MeanFraction(const AxisSample& sample, float width) {
  float sum = 0;
  for (size_t k = 0; k < sample.count; ++k)
    sum += std::min(1.0F, (sample.high[k] - sample.low[k]) / width);
  return sum / static_cast<float>(sample.count);
}

// Returns the axis on which boxes cover the smallest fraction of the range. If all fractions are 0
// (points), it returns the axis with the widest range.
int BestSweepAxis(const float (&fraction)[3], const CoordinateRange& range) {
  const float widest = std::max({range.width(0), range.width(1), range.width(2)});
  int best = 0;
  float best_cost = std::numeric_limits<float>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const float cost = fraction[axis] + 1e-5F * (widest / range.width(axis));
    if (cost >= best_cost) continue;
    best = axis;
    best_cost = cost;
  }
  return best;
}

}  // namespace

size_t DrawIndex(size_t k, size_t box_count) {
  const uint64_t fraction = (k * math::kGoldenGamma) >> 32;  // a fraction in [0, 1), times 2^32
  return static_cast<size_t>((fraction * box_count) >> 32);
}

CoordinateRange CoordinateRange::Sample(std::span<const Aabb> boxes) {
  AxisSample samples[3];
  const size_t draws =
      std::min(boxes.size(), boxes.size() < kFewBoxes ? kSmallSampleCount : kSampleCount);
  for (size_t k = 0; k < draws; ++k) {
    const Aabb& box = boxes[draws == boxes.size() ? k : DrawIndex(k, boxes.size())];
    if (!IsValid(box)) continue;
    for (int axis = 0; axis < 3; ++axis) samples[axis].Add(box.min[axis], box.max[axis]);
  }
  CoordinateRange range;
  if (samples[0].count == 0) return range;
  float fraction[3];
  for (int axis = 0; axis < 3; ++axis) {
    AxisSample bounds = samples[axis];  // a copy, since SetBounds reorders it
    SetBounds(bounds, range.low[axis], range.high[axis]);
    fraction[axis] = MeanFraction(samples[axis], range.width(axis));
    if (IsCrowded(samples[axis], range.low[axis], range.width(axis)))
      range.lines[static_cast<size_t>(axis)] = SpreadEvenly(samples[axis]);
  }
  range.sweep_axis = BestSweepAxis(fraction, range);
  return range;
}

}  // namespace sweepstake
