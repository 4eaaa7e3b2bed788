#include "engine_client/broad_phase/kd/kd_centers.h"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/kd/kd_centers.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// After foreach_target.h.
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Lanes16 = hn::CappedTag<float, KdRange::kPart>;

// Lanes of sentinels are left out.
size_t Collect(const BoxGroups& groups, const KdColumns& centers, const KdColumns& extents) {
  const Lanes16 d;
  const hn::RebindToUnsigned<Lanes16> du;
  const auto half = hn::Set(d, 0.5F);
  const auto greatest = hn::Set(d, std::numeric_limits<float>::max());
  size_t count = 0;
  for (size_t group = 0; group < groups.count; ++group) {
    for (size_t lane = 0; lane < BoxGroups::kWidth; lane += hn::Lanes(d)) {
      const size_t at = group * groups.stride + lane;
      const auto present = hn::Le(hn::LoadU(d, groups.min[0] + at), greatest);
      for (size_t axis = 0; axis < 3; ++axis) {
        const auto min = hn::LoadU(d, groups.min[axis] + at);
        const auto max = hn::LoadU(d, groups.max[axis] + at);
        // Halves: the sum of two finite floats need not be finite.
        const auto center = hn::Add(hn::Mul(min, half), hn::Mul(max, half));
        hn::StoreU(hn::Compress(center, present), d, centers.center[axis] + count);
        hn::StoreU(hn::Compress(hn::Sub(max, min), present), d, extents.center[axis] + count);
      }
      const auto id = hn::LoadU(du, groups.id + at);
      hn::StoreU(hn::Compress(id, hn::RebindMask(du, present)), du, centers.box + count);
      count += hn::CountTrue(d, present);
    }
  }
  return count;
}

// The sum is of parts that a float adds up without losing much.
AxisSpread Spread(const float* centers, const float* extents, size_t count) {
  const Lanes16 d;
  constexpr size_t kPartSize = 4096;
  auto least = hn::Set(d, centers[0]);
  auto greatest = least;
  auto longest = hn::Zero(d);
  double extent_sum = 0;
  for (size_t part = 0; part < count; part += kPartSize) {
    const size_t end = count - part < kPartSize ? count : part + kPartSize;
    auto sum = hn::Zero(d);
    for (size_t at = part; at < end; at += hn::Lanes(d)) {
      const auto inside = hn::FirstN(d, end - at);
      const auto center = hn::IfThenElse(inside, hn::LoadU(d, centers + at), least);
      const auto extent = hn::IfThenElseZero(inside, hn::LoadU(d, extents + at));
      least = hn::Min(least, center);
      greatest = hn::Max(greatest, center);
      longest = hn::Max(longest, extent);
      sum = hn::Add(sum, extent);
    }
    extent_sum += double{hn::GetLane(hn::SumOfLanes(d, sum))};
  }
  return {hn::GetLane(hn::MinOfLanes(d, least)), hn::GetLane(hn::MaxOfLanes(d, greatest)),
          hn::GetLane(hn::MaxOfLanes(d, longest)), extent_sum};
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(Collect);
HWY_EXPORT(Spread);

size_t CollectCenters(const BoxGroups& groups, const KdColumns& centers, const KdColumns& extents) {
  return HWY_DYNAMIC_DISPATCH(Collect)(groups, centers, extents);
}

AxisSpread SpreadOf(const float* centers, const float* extents, size_t count) {
  return HWY_DYNAMIC_DISPATCH(Spread)(centers, extents, count);
}

}  // namespace sweepstake

#endif  // HWY_ONCE
