// Bounds of the sixteen boxes of a leaf or children of a node, for every target of Highway. Include
// after hwy/foreach_target.h.
#if defined(SWEEPSTAKE_LEAF_BOUNDS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SWEEPSTAKE_LEAF_BOUNDS_INL_H_
#undef SWEEPSTAKE_LEAF_BOUNDS_INL_H_
#else
#define SWEEPSTAKE_LEAF_BOUNDS_INL_H_
#endif

#include <cstddef>

#include "engine_client/broad_phase/kd/leaf_tree.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Lanes16 = hn::CappedTag<float, LeafTree::kWidth>;

// The 16 values from `values` on, reduced to one.
HWY_INLINE float LeastOf16(const float* values) {
  const Lanes16 d;
  auto least = hn::LoadU(d, values);
  for (size_t at = hn::Lanes(d); at < LeafTree::kWidth; at += hn::Lanes(d)) {
    least = hn::Min(least, hn::LoadU(d, values + at));
  }
  return hn::GetLane(hn::MinOfLanes(d, least));
}

HWY_INLINE float GreatestOf16(const float* values) {
  const Lanes16 d;
  auto greatest = hn::LoadU(d, values);
  for (size_t at = hn::Lanes(d); at < LeafTree::kWidth; at += hn::Lanes(d)) {
    greatest = hn::Max(greatest, hn::LoadU(d, values + at));
  }
  return hn::GetLane(hn::MaxOfLanes(d, greatest));
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
