// Functions on registers of 1, 2, 4, 8 or 16 lanes, compiled for every target of Highway. Every
// node and leaf holds sixteen boxes, which fill a whole number of such registers. Include after
// hwy/foreach_target.h.
#if defined(SWEEPSTAKE_LANES16_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SWEEPSTAKE_LANES16_INL_H_
#undef SWEEPSTAKE_LANES16_INL_H_
#else
#define SWEEPSTAKE_LANES16_INL_H_
#endif

#include <cstddef>
#include <cstdint>

#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Lanes16 = hn::CappedTag<float, 16>;

HWY_INLINE float MinOf16(const float* values) {
  const Lanes16 d;
  auto min = hn::LoadU(d, values);
  for (size_t at = hn::Lanes(d); at < 16; at += hn::Lanes(d)) {
    min = hn::Min(min, hn::LoadU(d, values + at));
  }
  return hn::GetLane(hn::MinOfLanes(d, min));
}

HWY_INLINE float MaxOf16(const float* values) {
  const Lanes16 d;
  auto max = hn::LoadU(d, values);
  for (size_t at = hn::Lanes(d); at < 16; at += hn::Lanes(d)) {
    max = hn::Max(max, hn::LoadU(d, values + at));
  }
  return hn::GetLane(hn::MaxOfLanes(d, max));
}

// Returns the numbers first, first + 1 and so on. hn::Iota with a variable start is slow, since it
// writes the lanes one by one.
template <class DU>
HWY_INLINE hn::Vec<DU> NumbersFrom(DU du, size_t first) {
  return hn::Add(hn::Iota(du, 0), hn::Set(du, static_cast<uint32_t>(first)));
}

// Returns the mask as bits; bit k is lane k. REQUIRES: sixteen lanes or fewer.
template <class D>
HWY_INLINE uint32_t BitsOfMask([[maybe_unused]] D d, hn::Mask<D> mask) {
#if HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86
  return mask.raw;
#else
  uint8_t bits[8] = {};
  hn::StoreMaskBits(d, mask, bits);
  return bits[0] | uint32_t{bits[1]} << 8;
#endif
}

// Returns the mask in which lane k is set if bit k of `bits` is set.
template <class D>
HWY_INLINE hn::Mask<D> MaskOfBits([[maybe_unused]] D d, uint32_t bits) {
#if HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86
  using M = hn::Mask<D>;
  return M{static_cast<decltype(M::raw)>(bits)};
#else
  const uint8_t stored[8] = {static_cast<uint8_t>(bits), static_cast<uint8_t>(bits >> 8)};
  return hn::LoadMaskBits(d, stored);
#endif
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
