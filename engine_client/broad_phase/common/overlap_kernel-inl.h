// Vector kernels of the overlap test of aabb.h, for every target of Highway. Include after
// hwy/foreach_target.h, use inside HWY_NAMESPACE, dispatch once per operation (brute_force.cc shows
// how).
//
// All read BoxLanes, whose padding makes reads past the last box safe, and write pairs a < b
// through a PairCursor. Each returns the AABB checks it made: every lane of a comparison is one.
#if defined(SWEEPSTAKE_OVERLAP_KERNEL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SWEEPSTAKE_OVERLAP_KERNEL_INL_H_
#undef SWEEPSTAKE_OVERLAP_KERNEL_INL_H_
#else
#define SWEEPSTAKE_OVERLAP_KERNEL_INL_H_
#endif

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "engine_client/broad_phase/common/pair_cursor.h"
#include "engine_client/broad_phase/common/soa_boxes.h"
#include "hwy/highway.h"
#include "sweepstake/aabb.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// How a test treats the first axis of the lanes.
enum class FirstAxis {
  kBothSides,  // like the other axes
  kSorted,  // lanes start no earlier than the box does: only "has it ended before the lane starts"
            // is asked
};

HWY_INLINE Aabb BoxAt(const BoxLanes& lanes, size_t slot) {
  return {{lanes.min[0][slot], lanes.min[1][slot], lanes.min[2][slot]},
          {lanes.max[0][slot], lanes.max[1][slot], lanes.max[2][slot]}};
}

// Lanes set in both. On AVX-512 without the mask intrinsic: as a plain integer "and" the compiler
// folds it into the comparison that made `b`, and the tile of brute force takes a tenth less.
template <class M>
HWY_INLINE M Both(M a, M b) {
#if HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86
  return M{static_cast<decltype(M::raw)>(a.raw & b.raw)};
#else
  return hn::And(a, b);
#endif
}

// Those of the lanes `asked` that meet `box` on one axis.
template <class D>
HWY_INLINE hn::Mask<D> AxisHits(D d, hn::Mask<D> asked, const Aabb& box, const BoxLanes& lanes,
                                size_t axis, size_t at) {
  asked = Both(asked, hn::Le(hn::LoadU(d, lanes.min[axis] + at), hn::Set(d, box.max[axis])));
  return Both(asked, hn::Ge(hn::LoadU(d, lanes.max[axis] + at), hn::Set(d, box.min[axis])));
}

// Which of the lanes from slot `at` on overlap `box`, whose axes are in the lanes' order. Four
// calls with four boxes and the same `at` share their loads.
template <FirstAxis kFirst = FirstAxis::kBothSides, class D>
HWY_INLINE hn::Mask<D> Hits(D d, const Aabb& box, const BoxLanes& lanes, size_t at) {
  auto hits = hn::Le(hn::LoadU(d, lanes.min[0] + at), hn::Set(d, box.max[0]));
  if constexpr (kFirst == FirstAxis::kBothSides) {
    hits = Both(hits, hn::Ge(hn::LoadU(d, lanes.max[0] + at), hn::Set(d, box.min[0])));
  }
  return AxisHits(d, AxisHits(d, hits, box, lanes, 1, at), box, lanes, 2, at);
}

// All lanes but those of slots before `first`, when lane 0 is slot `at`.
template <class D>
HWY_INLINE hn::Mask<D> SlotsFrom(D d, size_t first, size_t at) {
  return hn::Not(hn::FirstN(d, first > at ? first - at : 0));
}

// Stores (id, ids[lane]) with a < b for each hit and returns how many; a whole register of pairs is
// written at `out`. No branch: where hits are frequent, mispredicting costs more than storing.
template <class D>
HWY_INLINE size_t StoreHits(D d, hn::Mask<D> hits, uint32_t id, const uint32_t* ids,
                            OverlapPair* out) {
  const hn::RebindToUnsigned<D> du;
  const auto others = hn::Compress(hn::LoadU(du, ids), hn::RebindMask(du, hits));
  const auto self = hn::Set(du, id);
  hn::StoreInterleaved2(hn::Min(self, others), hn::Max(self, others), du, &out->a);
  return hn::CountTrue(d, hits);
}

// Box `id` against the slots [begin, end).
template <FirstAxis kFirst = FirstAxis::kBothSides, class D>
HWY_INLINE uint64_t ScanRange(D d, const Aabb& box, uint32_t id, const BoxLanes& lanes,
                              size_t begin, size_t end, PairCursor& cursor) {
  const size_t step = hn::Lanes(d);
  uint64_t checks = 0;
  for (size_t at = begin; at < end; at += step) {
    const auto inside = hn::FirstN(d, end - at);
    const auto hits = hn::And(inside, Hits<kFirst>(d, box, lanes, at));
    cursor.Advance(StoreHits(d, hits, id, lanes.id + at, cursor.Room(step)));
    checks += step;
  }
  return checks;
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
