#include "engine_client/broad_phase/box_record.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/box_record.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// After foreach_target.h.
#include "engine_client/broad_phase/box_record-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

void LoadRecords(std::span<const Aabb> boxes, BoxRecord* records) {
  for (size_t i = 0; i < boxes.size(); ++i) records[i] = LoadRecord(boxes[i]);
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(LoadRecords);

void TakeRecords(std::span<const Aabb> boxes, BoxRecord* records) {
  HWY_DYNAMIC_DISPATCH(LoadRecords)(boxes, records);
}

}  // namespace sweepstake

#endif  // HWY_ONCE
