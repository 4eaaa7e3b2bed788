// Cell numbers of whole registers of coordinates, for every target of Highway. Include after
// hwy/foreach_target.h.
#if defined(SWEEPSTAKE_GRID_CELLS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SWEEPSTAKE_GRID_CELLS_INL_H_
#undef SWEEPSTAKE_GRID_CELLS_INL_H_
#else
#define SWEEPSTAKE_GRID_CELLS_INL_H_
#endif

#include <cstddef>

#include "engine_client/broad_phase/grid_layout.h"
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// As GridLayout::CellOf; sentinels get the first or the last cell.
template <class D>
HWY_INLINE hn::Vec<hn::RebindToSigned<D>> CellsOf(D d, const GridLayout& layout, size_t axis,
                                                  const float* coordinates) {
  const auto halved = hn::Mul(hn::LoadU(d, coordinates), hn::Set(d, 0.5F));
  const auto cell =
      hn::Mul(hn::Sub(halved, hn::Set(d, layout.origin[axis])), hn::Set(d, layout.scale[axis]));
  const auto last = hn::Set(d, static_cast<float>(layout.cells[axis] - 1));
  const hn::RebindToSigned<D> di;
  return hn::ConvertTo(di, hn::Min(hn::Max(cell, hn::Zero(d)), last));
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
