#include "engine_client/broad_phase/sweep_kernel.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/sweep_kernel.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// After foreach_target.h.
#include "engine_client/broad_phase/overlap_kernel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

uint64_t SweepTiles(const BoxLanes& lanes, PairBuffer& out) {
  return ScanAllTiles<FirstAxis::kSorted>(lanes, out);
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(SweepTiles);

uint64_t SweepSorted(const BoxLanes& lanes, PairBuffer& out) {
  return HWY_DYNAMIC_DISPATCH(SweepTiles)(lanes, out);
}

}  // namespace sweepstake

#endif  // HWY_ONCE
