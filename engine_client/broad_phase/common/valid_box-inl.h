// Finds the lanes that hold a valid box (IsValid in aabb.h), compiled for every target of Highway.
// Include after hwy/foreach_target.h.
#if defined(SWEEPSTAKE_VALID_BOX_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SWEEPSTAKE_VALID_BOX_INL_H_
#undef SWEEPSTAKE_VALID_BOX_INL_H_
#else
#define SWEEPSTAKE_VALID_BOX_INL_H_
#endif

#include <limits>

#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Returns the lanes whose box is valid on one axis. NaN fails every comparison; infinities fail the
// first two.
template <class D>
HWY_INLINE hn::Mask<D> IsValidOnAxis(D d, const float* min, const float* max) {
  const auto low = hn::LoadU(d, min);
  const auto high = hn::LoadU(d, max);
  const auto limit = hn::Set(d, std::numeric_limits<float>::max());
  const auto finite = hn::And(hn::Ge(low, hn::Neg(limit)), hn::Le(high, limit));
  return hn::And(finite, hn::Le(low, high));
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
