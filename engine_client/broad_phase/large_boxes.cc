#include "engine_client/broad_phase/large_boxes.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/large_boxes.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// After foreach_target.h.
#include "engine_client/broad_phase/overlap_kernel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

uint64_t PairsOfLast(const BoxLanes& lanes, size_t begin, size_t end, PairBuffer& out) {
  const HWY_FULL(float) d;
  const BoxLanes local = lanes;
  PairCursor cursor(out);
  uint64_t checks = 0;
  for (size_t slot = begin; slot < end; ++slot) {
    const Aabb box = BoxAt(local, slot);
    checks += ScanRange(d, box, local.id[slot], local, 0, begin, cursor);
    checks += ScanRange(d, box, local.id[slot], local, slot + 1, end, cursor);
  }
  cursor.Flush();
  return checks;
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(PairsOfLast);

uint64_t FindPairsOfLast(const BoxLanes& lanes, size_t begin, size_t end, PairBuffer& out) {
  if (begin == end) return 0;
  return HWY_DYNAMIC_DISPATCH(PairsOfLast)(lanes, begin, end, out);
}

}  // namespace sweepstake

#endif  // HWY_ONCE
