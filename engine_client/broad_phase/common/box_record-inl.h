// Functions on box records (box_record.h), compiled for every target of Highway. The vector
// versions return the same results as the scalar ones. Include after hwy/foreach_target.h, use
// inside HWY_NAMESPACE.
#if defined(SWEEPSTAKE_BOX_RECORD_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SWEEPSTAKE_BOX_RECORD_INL_H_
#undef SWEEPSTAKE_BOX_RECORD_INL_H_
#else
#define SWEEPSTAKE_BOX_RECORD_INL_H_
#endif

#include <limits>

#include "engine_client/broad_phase/common/box_record.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR

// The result is stored through a reference. A record returned by value would be stored in two
// halves and then loaded whole, and that load would wait until both stores have finished.
HWY_INLINE void StoreRecord(const Aabb& box, BoxRecord& record) { record = RecordOf(box); }

HWY_INLINE bool RecordsOverlap(const BoxRecord& a, const BoxRecord& b) { return Overlap(a, b); }
HWY_INLINE bool RecordsAreEqual(const BoxRecord& a, const BoxRecord& b) { return a == b; }

#else

using RecordHalf = hn::FixedTag<float, 4>;

HWY_INLINE void StoreRecord(const Aabb& box, BoxRecord& record) {
  const RecordHalf d;
  const auto first_three = hn::FirstN(d, 3);
  const auto limit = hn::Set(d, std::numeric_limits<float>::max());
  const auto min = hn::IfThenElseZero(first_three, hn::LoadU(d, box.min));
  // The load begins at min[2], so that no memory behind the box is read.
  const auto max = hn::ShiftRightLanes<1>(d, hn::LoadU(d, box.min + 2));
  const auto finite = hn::And(hn::Ge(min, hn::Neg(limit)), hn::Le(max, limit));
  if (HWY_UNLIKELY(!hn::AllTrue(d, hn::And(finite, hn::Le(min, max))))) {
    record = kInvalidRecord;
    return;
  }
  hn::Store(min, d, record.min);
  hn::Store(max, d, record.max);
}

HWY_INLINE bool RecordsOverlap(const BoxRecord& a, const BoxRecord& b) {
  const RecordHalf d;
  return hn::AllTrue(d, hn::And(hn::Le(hn::Load(d, a.min), hn::Load(d, b.max)),
                                hn::Le(hn::Load(d, b.min), hn::Load(d, a.max))));
}

HWY_INLINE bool RecordsAreEqual(const BoxRecord& a, const BoxRecord& b) {
  const RecordHalf d;
  return hn::AllTrue(d, hn::And(hn::Eq(hn::Load(d, a.min), hn::Load(d, b.min)),
                                hn::Eq(hn::Load(d, a.max), hn::Load(d, b.max))));
}

#endif

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
