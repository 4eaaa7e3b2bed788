#include "engine_client/broad_phase/tracy_ranges.h"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/tracy_ranges.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// After foreach_target.h.
#include "engine_client/broad_phase/grid_cells-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

void RangesOf(const BoxLanes& lanes, const GridLayout& layout, CellRange* ranges) {
  const HWY_FULL(float) d;
  const hn::RebindToSigned<decltype(d)> di;
  const hn::RebindToUnsigned<decltype(d)> du;
  const auto infinity = hn::Set(d, std::numeric_limits<float>::infinity());
  const auto most = hn::Set(di, CellRange::kMostCells);
  const int32_t strides[3] = {1, static_cast<int32_t>(layout.cells[0]),
                              static_cast<int32_t>(layout.cells[0] * layout.cells[1])};
  for (size_t at = 0; at < lanes.count; at += hn::Lanes(d)) {
    auto first = hn::Zero(di);
    auto last = hn::Zero(di);
    auto cells = hn::Set(di, 1);
    for (size_t axis = 0; axis < 3; ++axis) {
      const auto from = CellsOf(d, layout, axis, lanes.min[axis] + at);
      const auto to = CellsOf(d, layout, axis, lanes.max[axis] + at);
      first = hn::Add(first, hn::Mul(from, hn::Set(di, strides[axis])));
      last = hn::Add(last, hn::Mul(to, hn::Set(di, strides[axis])));
      // Capped, so that the product of three cannot overflow.
      const auto span = hn::Add(hn::Sub(to, from), hn::Set(di, 1));
      cells = hn::Mul(cells, hn::Min(span, hn::Add(most, hn::Set(di, 1))));
    }
    const auto absent = hn::RebindMask(di, hn::Eq(hn::LoadU(d, lanes.min[0] + at), infinity));
    first = hn::IfThenElse(hn::Gt(cells, most),
                           hn::Set(di, static_cast<int32_t>(CellRange::kLarge)), first);
    first = hn::IfThenElse(absent, hn::Set(di, static_cast<int32_t>(CellRange::kAbsent)), first);
    hn::StoreInterleaved2(hn::BitCast(du, first), hn::BitCast(du, last), du, &ranges[at].first);
  }
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(RangesOf);

void FindRanges(const BoxLanes& lanes, const GridLayout& layout, CellRange* ranges) {
  HWY_DYNAMIC_DISPATCH(RangesOf)(lanes, layout, ranges);
}

}  // namespace sweepstake

#endif  // HWY_ONCE
