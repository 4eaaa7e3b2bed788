// Overlaps with a box.
#include "engine_client/broad_phase/proxies/tree_walk.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/proxies/overlap_walk.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// After foreach_target.h.
#include "engine_client/broad_phase/proxies/tree_walk-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

void WalkOverlapping(const TreeView& tree, const Aabb& box, const IdSink& sink) {
  const uint32_t* const ids = tree.levels[0].id;
  Descend(
      tree, 0,
      [&](const BoxLanes& lanes, size_t base, FoundGroup& found)
          HWY_ATTR { CollectOverlapping(box, lanes, base, found); },
      [&](const FoundGroup& found) {
        uint32_t found_ids[LeafTree::kWidth];
        for (size_t k = 0; k < found.count; ++k) found_ids[k] = ids[found.entry[k]];
        sink.take(sink.context, found_ids, found.count);
      });
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(WalkOverlapping);

void FindOverlapping(const TreeView& tree, const Aabb& box, const IdSink& sink) {
  if (TakesPart(box)) HWY_DYNAMIC_DISPATCH(WalkOverlapping)(tree, box, sink);
}

}  // namespace sweepstake

#endif  // HWY_ONCE
