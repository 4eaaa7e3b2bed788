// Vector forms of the overlap test of aabb.h, for every target of Highway. Include after
// hwy/foreach_target.h, use inside HWY_NAMESPACE, and dispatch once per operation.
//
// All functions read boxes in columns with padding, since they may read a whole register behind the
// last box. A lane of a comparison counts as one AABB check.
#if defined(SWEEPSTAKE_OVERLAP_KERNEL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SWEEPSTAKE_OVERLAP_KERNEL_INL_H_
#undef SWEEPSTAKE_OVERLAP_KERNEL_INL_H_
#else
#define SWEEPSTAKE_OVERLAP_KERNEL_INL_H_
#endif

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "engine_client/broad_phase/common/compress-inl.h"
#include "engine_client/broad_phase/common/pair_cursor.h"
#include "engine_client/broad_phase/common/soa_boxes.h"
#include "hwy/highway.h"
#include "sweepstake/aabb.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

HWY_INLINE Aabb BoxAt(const BoxLanes& lanes, size_t slot) {
  return {{lanes.min[0][slot], lanes.min[1][slot], lanes.min[2][slot]},
          {lanes.max[0][slot], lanes.max[1][slot], lanes.max[2][slot]}};
}

// Returns the lanes set in both masks. On AVX-512 it is an integer "and" instead of the mask
// intrinsic. The compiler would merge the intrinsic with the comparison that computes `b`, which
// would then have to wait for `a`.
template <class M>
HWY_INLINE M Both(M a, M b) {
#if HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86
  return M{static_cast<decltype(M::raw)>(a.raw & b.raw)};
#else
  return hn::And(a, b);
#endif
}

// Returns the lanes from slot `at` on that overlap `box`, whose axes are in the order of `lanes`.
// The comparisons form two independent chains, so that the processor can run them in parallel.
template <class D>
HWY_INLINE hn::Mask<D> Hits(D d, const Aabb& box, const BoxLanes& lanes, size_t at) {
  auto begins = hn::Le(hn::LoadU(d, lanes.min[0] + at), hn::Set(d, box.max[0]));
  auto ends = hn::Ge(hn::LoadU(d, lanes.max[0] + at), hn::Set(d, box.min[0]));
  for (size_t axis = 1; axis < 3; ++axis) {
    begins = Both(begins, hn::Le(hn::LoadU(d, lanes.min[axis] + at), hn::Set(d, box.max[axis])));
    ends = Both(ends, hn::Ge(hn::LoadU(d, lanes.max[axis] + at), hn::Set(d, box.min[axis])));
  }
  return hn::And(begins, ends);
}

// Returns the lanes of boxes in registers (one vector per face) that overlap another box. The other
// box's coordinates begin at `min` and at `max` and are kStride floats apart.
template <size_t kStride, class D, class V>
HWY_INLINE hn::Mask<D> HeldHits(D d, V min0, V min1, V min2, V max0, V max1, V max2,
                                const float* min, const float* max) {
  const auto begins =
      Both(Both(hn::Le(min0, hn::Set(d, max[0])), hn::Le(min1, hn::Set(d, max[kStride]))),
           hn::Le(min2, hn::Set(d, max[2 * kStride])));
  const auto ends =
      Both(Both(hn::Ge(max0, hn::Set(d, min[0])), hn::Ge(max1, hn::Set(d, min[kStride]))),
           hn::Ge(max2, hn::Set(d, min[2 * kStride])));
  return hn::And(begins, ends);
}

// Returns a mask of the slots from `first` on. Lane 0 is slot `at`.
template <class D>
HWY_INLINE hn::Mask<D> SlotsFrom(D d, size_t first, size_t at) {
  return hn::Not(hn::FirstN(d, first > at ? first - at : 0));
}

// Stores a pair of `self` and each of the first `count` partners, the smaller id first. The second
// half of the register of pairs is stored only if `count` requires it. With kAlways it is always
// stored, which is faster if the second half is often needed. Grid's search uses StoreFewHits
// instead: with AVX-512, StoreFewHits takes a fifth less time in Grid, but would take up to a fifth
// more in KDTree and DBVT.
template <bool kAlways, class V>
HWY_INLINE void StorePairs(V self, V partners, [[maybe_unused]] size_t count, OverlapPair* out) {
  const hn::DFromV<V> du;
#if HWY_TARGET == HWY_SCALAR || HWY_HAVE_SCALABLE
  hn::StoreInterleaved2(hn::Min(self, partners), hn::Max(self, partners), du, &out->a);
#else
  const size_t half = hn::Lanes(du) / 2;
#if HWY_MAX_BYTES == 64
  // Duplicates every partner, then puts the smaller id on the left and the larger on the right.
  // Interleaving takes twice as many instructions.
  const auto pairs_from = [&](size_t first) HWY_ATTR {
    const auto lanes = hn::ShiftRight<1>(NumbersFrom(du, 2 * first));
    const auto twice = hn::TableLookupLanes(partners, hn::IndicesFromVec(du, lanes));
    return hn::OddEven(hn::Max(self, twice), hn::Min(self, twice));
  };
  hn::StoreU(pairs_from(0), du, &out->a);
  if (!kAlways && HWY_LIKELY(count <= half)) return;
  hn::StoreU(pairs_from(half), du, &out[half].a);
#else
  const auto min = hn::Min(self, partners);
  const auto max = hn::Max(self, partners);
  auto lower = hn::InterleaveLower(du, min, max);
  auto upper = hn::InterleaveUpper(du, min, max);
#if HWY_MAX_BYTES == 32
  const auto lower_of_blocks = lower;
  lower = hn::ConcatLowerLower(du, upper, lower_of_blocks);
  upper = hn::ConcatUpperUpper(du, upper, lower_of_blocks);
#endif
  hn::StoreU(lower, du, &out->a);
  if (!kAlways && HWY_LIKELY(count <= half)) return;
  hn::StoreU(upper, du, &out[half].a);
#endif
#endif
}

// Stores (id, ids[lane]) with a < b for each hit and returns their number. It always writes a whole
// register of pairs to `out`. If hits are frequent, mispredicted branches would cost more than the
// unneeded stores.
template <class D>
HWY_INLINE size_t StoreHits(D d, hn::Mask<D> hits, uint32_t id, const uint32_t* ids,
                            OverlapPair* out) {
  const hn::RebindToUnsigned<D> du;
  const auto others = CompressLanes(hn::LoadU(du, ids), hn::RebindMask(du, hits));
  const size_t count = hn::CountTrue(d, hits);
  StorePairs<true>(hn::Set(du, id), others, count, out);
  return count;
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
