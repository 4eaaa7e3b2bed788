#include "engine_client/broad_phase/common/box_record.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/common/box_record.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// The includes below must come after foreach_target.h.
#include "engine_client/broad_phase/common/box_record-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

void LoadRecords(std::span<const Aabb> boxes, BoxRecord* records) {
  for (size_t i = 0; i < boxes.size(); ++i) StoreRecord(boxes[i], records[i]);
}

size_t CollectMoved(std::span<const Aabb> boxes, const BoxRecord* records, uint32_t* moved) {
  size_t count = 0;
  for (size_t i = 0; i < boxes.size(); ++i) {
    BoxRecord record;
    StoreRecord(boxes[i], record);
    moved[count] = static_cast<uint32_t>(i) | (record.min[0] == kInfinity ? kBecameInvalid : 0);
    count += RecordsAreEqual(record, records[i]) ? 0 : 1;
  }
  return count;
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(LoadRecords);
HWY_EXPORT(CollectMoved);

void StoreRecords(std::span<const Aabb> boxes, BoxRecord* records) {
  HWY_DYNAMIC_DISPATCH(LoadRecords)(boxes, records);
}

size_t FindMoved(std::span<const Aabb> boxes, const BoxRecord* records, uint32_t* moved) {
  return HWY_DYNAMIC_DISPATCH(CollectMoved)(boxes, records, moved);
}

}  // namespace sweepstake

#endif  // HWY_ONCE
