#include "engine_client/broad_phase/kd/kd_centers.h"

#include <algorithm>
#include <cmath>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/kd/kd_centers.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// The includes below must come after foreach_target.h.
#include "engine_client/broad_phase/common/compress-inl.h"
#include "engine_client/broad_phase/common/lanes16-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

size_t Collect(std::span<const LeafBlock> leaves, const KdColumns& centers,
               const KdColumns& extents) {
  const Lanes16 d;
  const hn::RebindToUnsigned<Lanes16> du;
  const auto half = hn::Set(d, 0.5F);
  const auto max_float = hn::Set(d, std::numeric_limits<float>::max());
  size_t count = 0;
  for (const LeafBlock& leaf : leaves) {
    for (size_t at = 0; at < LeafBlock::kWidth; at += hn::Lanes(d)) {
      // Skips sentinels, which mark slots without a valid box (min = +inf).
      const auto valid = hn::Le(hn::LoadU(d, leaf.min[0] + at), max_float);
      for (size_t axis = 0; axis < 3; ++axis) {
        const auto min = hn::LoadU(d, leaf.min[axis] + at);
        const auto max = hn::LoadU(d, leaf.max[axis] + at);
        // The halves are added, since the sum of two floats may overflow.
        const auto center = hn::Add(hn::Mul(min, half), hn::Mul(max, half));
        hn::StoreU(CompressLanes(center, valid), d, centers.center[axis] + count);
        hn::StoreU(CompressLanes(hn::Sub(max, min), valid), d, extents.center[axis] + count);
      }
      const auto id = hn::LoadU(du, leaf.id + at);
      hn::StoreU(CompressLanes(id, hn::RebindMask(du, valid)), du, centers.box + count);
      count += hn::CountTrue(d, valid);
    }
  }
  return count;
}

// Computes the spread of `count` boxes. A float sum of many extents would be inexact, so that parts
// of kPartSize are summed and added as doubles.
AxisSpread Spread(const float* centers, const float* extents, size_t count) {
  const Lanes16 d;
  constexpr size_t kPartSize = 4096;
  auto min = hn::Set(d, centers[0]);
  auto max = min;
  auto max_extent = hn::Zero(d);
  double extent_sum = 0;
  for (size_t part = 0; part < count; part += kPartSize) {
    const size_t end = count - part < kPartSize ? count : part + kPartSize;
    auto sum = hn::Zero(d);
    for (size_t at = part; at < end; at += hn::Lanes(d)) {
      const auto inside = hn::FirstN(d, end - at);
      const auto center = hn::IfThenElse(inside, hn::LoadU(d, centers + at), min);
      const auto extent = hn::IfThenElseZero(inside, hn::LoadU(d, extents + at));
      min = hn::Min(min, center);
      max = hn::Max(max, center);
      max_extent = hn::Max(max_extent, extent);
      sum = hn::Add(sum, extent);
    }
    extent_sum += double{hn::GetLane(hn::SumOfLanes(d, sum))};
  }
  return {hn::GetLane(hn::MinOfLanes(d, min)), hn::GetLane(hn::MaxOfLanes(d, max)),
          hn::GetLane(hn::MaxOfLanes(d, max_extent)), extent_sum};
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(Collect);
HWY_EXPORT(Spread);

namespace {

// A box is large if one of its sides exceeds this multiple of a leaf's width. For a smaller box, a
// separate class would cost more than the growth of its leaf.
constexpr double kLongInLeafWidths = 1.5;
// A large box must also exceed this multiple of the lower quartile of the extents on its axis.
constexpr float kLongInQuartiles = 4;
constexpr size_t kSampleSize = 64;

// Returns the lower quartile of the extents, estimated from a sample.
float LowerQuartile(const float* extents, size_t count) {
  std::array<float, kSampleSize> sample;
  for (size_t k = 0; k < kSampleSize; ++k) sample[k] = extents[k * count / kSampleSize];
  std::nth_element(sample.begin(), sample.begin() + kSampleSize / 4, sample.end());
  return sample[kSampleSize / 4];
}

}  // namespace

size_t CollectCenters(std::span<const LeafBlock> leaves, const KdColumns& centers,
                      const KdColumns& extents) {
  return HWY_DYNAMIC_DISPATCH(Collect)(leaves, centers, extents);
}

AxisSpread SpreadOf(const float* centers, const float* extents, size_t count) {
  return HWY_DYNAMIC_DISPATCH(Spread)(centers, extents, count);
}

SizeClasses::SizeClasses(const AxisSpread (&spreads)[3], const float* const (&extents)[3],
                         size_t count) {
  double room = double{LeafBlock::kWidth} / static_cast<double>(count);
  for (const AxisSpread& axis : spreads) {
    room *= double{axis.max_center} - double{axis.min_center} +
            axis.extent_sum / static_cast<double>(count);
  }
  step_ = static_cast<float>(kLongInLeafWidths * std::cbrt(room));
  for (size_t axis = 0; axis < 3; ++axis) {
    long_from_[axis] = std::max(step_, kLongInQuartiles * LowerQuartile(extents[axis], count));
    if (spreads[axis].max_extent > long_from_[axis]) all_ordinary_ = false;
  }
}

size_t SizeClasses::ClassOf(float extent0, float extent1, float extent2) const {
  if (extent0 <= long_from_[0] && extent1 <= long_from_[1] && extent2 <= long_from_[2]) return 0;
  const float longest = std::max({extent0, extent1, extent2});
  // A side is thin if the longest one is more than eight times as long.
  const float thin = longest * 0.125F;
  const size_t axes = (extent0 > std::max(long_from_[0], thin) ? 1U : 0U) |
                      (extent1 > std::max(long_from_[1], thin) ? 2U : 0U) |
                      (extent2 > std::max(long_from_[2], thin) ? 4U : 0U);
  size_t level = 0;
  for (float limit = step_ * 4; level < 3 && longest > limit; limit *= 4) ++level;
  return level * 8 + axes;
}

std::array<size_t, SizeClasses::kCount> SizeClasses::ClassifyAll(
    const float* const (&extents)[3], std::span<uint32_t> classes) const {
  std::array<size_t, kCount> counts{};
  for (size_t i = 0; i < classes.size(); ++i) {
    const size_t of_box = ClassOf(extents[0][i], extents[1][i], extents[2][i]);
    classes[i] = static_cast<uint32_t>(of_box);
    ++counts[of_box];
  }
  return counts;
}

}  // namespace sweepstake

#endif  // HWY_ONCE
