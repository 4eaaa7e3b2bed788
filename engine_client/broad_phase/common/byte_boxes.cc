#include "engine_client/broad_phase/common/byte_boxes.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/common/byte_boxes.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// The includes below must come after foreach_target.h.
#include "engine_client/broad_phase/common/box_record-inl.h"

#ifndef SWEEPSTAKE_BYTE_BOXES_ONCE
#define SWEEPSTAKE_BYTE_BOXES_ONCE
namespace sweepstake {

// The parameters of the function q (byte_boxes.h), in the layout of BoxRecord::min.
struct ByteScale {
  alignas(16) float origin[4];
  alignas(16) float scale[4];
  size_t axis[3];  // the coordinate stored in ByteLanes::low[k] and high[k]
};

}  // namespace sweepstake
#endif

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

HWY_INLINE void PutBytes(const ByteScale& scale, const BoxRecord& record, const ByteLanes& lanes,
                         size_t slot) {
  constexpr float kLast = 255;
  alignas(16) int32_t low[4];
  alignas(16) int32_t high[4];
  ToLevels(record.min, scale.origin, scale.scale, kLast, low);
  ToLevels(record.max, scale.origin, scale.scale, kLast, high);
  for (size_t k = 0; k < 3; ++k) {
    lanes.low[k][slot] = static_cast<uint8_t>(low[scale.axis[k]]);
    lanes.high[k][slot] = static_cast<uint8_t>(high[scale.axis[k]]);
  }
}

void FillFromBoxes(std::span<const Aabb> boxes, const ByteScale& scale, const SweepAxis& sweep,
                   const ByteLanes& lanes, BoxRecord* records, size_t begin, size_t end) {
  // No store can alias these local copies, so that the compiler keeps their fields in registers.
  const ByteScale local = scale;
  const ByteLanes to = lanes;
  const size_t axis = scale.axis[0];
  for (size_t slot = begin; slot < end; ++slot) {
    BoxRecord& record = records[slot];
    StoreRecord(boxes[to.id[slot]], record);
    PutBytes(local, record, to, slot);
    if (to.begin == nullptr) continue;
    to.begin[slot] = sweep.Position(record.min[axis]);
    to.end[slot] = sweep.Position(record.max[axis]);
  }
}

void FillFromRecords(const BoxRecord* records, const ByteScale& scale, const SweepAxis& sweep,
                     const ByteLanes& lanes, size_t begin, size_t end) {
  const ByteScale local = scale;  // a copy that no store can alias
  const ByteLanes to = lanes;
  const size_t axis = scale.axis[0];
  for (size_t slot = begin; slot < end; ++slot) {
    const BoxRecord& record = records[to.id[slot]];
    PutBytes(local, record, to, slot);
    to.begin[slot] = sweep.Position(record.min[axis]);
    to.end[slot] = sweep.Position(record.max[axis]);
  }
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(FillFromBoxes);
HWY_EXPORT(FillFromRecords);

namespace {

ByteScale ScaleOf(const CoordinateRange& range) {
  constexpr float kLevels = 256;
  ByteScale scale{};
  for (int axis = 0; axis < 3; ++axis) {
    scale.origin[axis] = range.low[axis];
    scale.scale[axis] = kLevels / range.width(axis);
    scale.axis[axis] = static_cast<size_t>((range.sweep_axis + axis) % 3);
  }
  return scale;
}

}  // namespace

void ByteBoxes::Resize(size_t count, bool swept) {
  ResizeSlots(count, swept);
  borrowed_ = nullptr;
  records_.EnsureDiscarding(stride_);
  std::fill(records_.data() + count_, records_.data() + stride_, kInvalidRecord);
}

void ByteBoxes::ResizeFor(const BoxRecord* records, size_t count) {
  ResizeSlots(count, true);
  borrowed_ = records;
}

void ByteBoxes::ResizeSlots(size_t count, bool swept) {
  count_ = count;
  stride_ = (count / kGranule + 1) * kGranule;
  swept_ = swept;
  bytes_.EnsureDiscarding(6 * stride_);
  ids_.EnsureDiscarding(stride_);
  if (swept) ends_.EnsureDiscarding(2 * stride_);
  PadSlots();
}

void ByteBoxes::PadSlots() {
  const ByteLanes lanes = Lanes();
  for (size_t slot = count_; slot < stride_; ++slot) {
    lanes.id[slot] = static_cast<uint32_t>(count_);
    for (size_t axis = 0; axis < 3; ++axis) {
      lanes.low[axis][slot] = 255;
      lanes.high[axis][slot] = 0;
    }
    if (!swept_) continue;
    lanes.begin[slot] = kInfinity;
    lanes.end[slot] = -kInfinity;
  }
}

void ByteBoxes::Fill(std::span<const Aabb> boxes, const CoordinateRange& range,
                     const SweepAxis& axis, size_t begin, size_t end) {
  HWY_DYNAMIC_DISPATCH(FillFromBoxes)
  (boxes, ScaleOf(range), axis, Lanes(), records_.data(), begin, end);
}

void ByteBoxes::Fill(const CoordinateRange& range, const SweepAxis& axis, size_t begin,
                     size_t end) {
  HWY_DYNAMIC_DISPATCH(FillFromRecords)(borrowed_, ScaleOf(range), axis, Lanes(), begin, end);
}

ByteLanes ByteBoxes::Lanes() {
  ByteLanes lanes{};
  for (size_t axis = 0; axis < 3; ++axis) {
    lanes.low[axis] = bytes_.data() + axis * stride_;
    lanes.high[axis] = bytes_.data() + (axis + 3) * stride_;
  }
  if (swept_) {
    lanes.begin = ends_.data();
    lanes.end = ends_.data() + stride_;
  }
  lanes.id = ids_.data();
  lanes.record = borrowed_ != nullptr ? borrowed_ : records_.data();
  lanes.records_by_id = borrowed_ != nullptr;
  lanes.count = count_;
  return lanes;
}

size_t ByteBoxes::native_bytes() const {
  return records_.capacity_bytes() + bytes_.capacity_bytes() + ends_.capacity_bytes() +
         ids_.capacity_bytes();
}

}  // namespace sweepstake

#endif  // HWY_ONCE
