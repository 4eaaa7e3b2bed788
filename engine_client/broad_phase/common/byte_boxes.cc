#include "engine_client/broad_phase/common/byte_boxes.h"

#include <algorithm>

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
  // q is the sum of these segments (PiecewiseLine), usually one.
  struct Segment {
    alignas(16) float origin[4];
    alignas(16) float scale[4];
    alignas(16) float rise[4];
  };
  Segment segments[CoordinateRange::kMaxSegments];
  size_t segment_count;
  size_t axis[3];  // the coordinate stored in ByteLanes::low[k] and high[k]
};

}  // namespace sweepstake
#endif

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

// Converts four coordinates to bytes.
#if HWY_TARGET == HWY_SCALAR
template <bool kOneSegment>
HWY_INLINE void ToLevels(const float* x, const ByteScale& scale, int32_t* levels) {
  for (size_t k = 0; k < 4; ++k) {
    float sum = 0;
    for (size_t s = 0; s < scale.segment_count; ++s) {
      const ByteScale::Segment& segment = scale.segments[s];
      const float level = (x[k] - segment.origin[k]) * segment.scale[k];
      sum += std::min(std::max(level, 0.0F), segment.rise[k]);
    }
    levels[k] = static_cast<int32_t>(sum);
  }
}
#else
template <bool kOneSegment>
HWY_INLINE void ToLevels(const float* x, const ByteScale& scale, int32_t* levels) {
  const RecordHalf d;
  const hn::RebindToSigned<RecordHalf> di;
  const auto of_segment = [&](const ByteScale::Segment& segment) HWY_ATTR {
    const auto from_origin = hn::Sub(hn::Load(d, x), hn::Load(d, segment.origin));
    const auto level = hn::Mul(from_origin, hn::Load(d, segment.scale));
    return hn::Min(hn::Max(level, hn::Zero(d)), hn::Load(d, segment.rise));
  };
  auto sum = of_segment(scale.segments[0]);
  for (size_t s = 1; !kOneSegment && s < scale.segment_count; ++s) {
    sum = hn::Add(sum, of_segment(scale.segments[s]));
  }
  hn::Store(hn::ConvertTo(di, sum), di, levels);
}
#endif

template <bool kOneSegment>
HWY_INLINE void PutBytes(const ByteScale& scale, const BoxRecord& record, const ByteLanes& lanes,
                         size_t slot) {
  alignas(16) int32_t low[4];
  alignas(16) int32_t high[4];
  ToLevels<kOneSegment>(record.min, scale, low);
  ToLevels<kOneSegment>(record.max, scale, high);
  for (size_t k = 0; k < 3; ++k) {
    lanes.low[k][slot] = static_cast<uint8_t>(low[scale.axis[k]]);
    lanes.high[k][slot] = static_cast<uint8_t>(high[scale.axis[k]]);
  }
}

template <bool kOneSegment>
void FillBoxes(std::span<const Aabb> boxes, const ByteScale& scale, const SweepAxis& sweep,
               const ByteLanes& lanes, BoxRecord* records, size_t begin, size_t end) {
  // No store can alias these local copies, so that the compiler keeps their fields in registers.
  const ByteScale local = scale;
  const ByteLanes to = lanes;
  const size_t axis = scale.axis[0];
  for (size_t slot = begin; slot < end; ++slot) {
    BoxRecord& record = records[slot];
    StoreRecord(boxes[to.id[slot]], record);
    PutBytes<kOneSegment>(local, record, to, slot);
    if (to.begin == nullptr) continue;
    to.begin[slot] = sweep.Position(record.min[axis]);
    to.end[slot] = sweep.Position(record.max[axis]);
  }
}

void FillFromBoxes(std::span<const Aabb> boxes, const ByteScale& scale, const SweepAxis& sweep,
                   const ByteLanes& lanes, BoxRecord* records, size_t begin, size_t end) {
  const auto fill = scale.segment_count == 1 ? FillBoxes<true> : FillBoxes<false>;
  fill(boxes, scale, sweep, lanes, records, begin, end);
}

template <bool kOneSegment>
void FillRecords(const BoxRecord* records, const ByteScale& scale, const SweepAxis& sweep,
                 const ByteLanes& lanes, size_t begin, size_t end) {
  const ByteScale local = scale;  // a copy that no store can alias
  const ByteLanes to = lanes;
  const size_t axis = scale.axis[0];
  for (size_t slot = begin; slot < end; ++slot) {
    const BoxRecord& record = records[to.id[slot]];
    PutBytes<kOneSegment>(local, record, to, slot);
    to.begin[slot] = sweep.Position(record.min[axis]);
    to.end[slot] = sweep.Position(record.max[axis]);
  }
}

void FillFromRecords(const BoxRecord* records, const ByteScale& scale, const SweepAxis& sweep,
                     const ByteLanes& lanes, size_t begin, size_t end) {
  const auto fill = scale.segment_count == 1 ? FillRecords<true> : FillRecords<false>;
  fill(records, scale, sweep, lanes, begin, end);
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(FillFromBoxes);
HWY_EXPORT(FillFromRecords);

namespace {

ByteScale ScaleOf(const CoordinateRange& range) {
  constexpr float kLast = 255;
  ByteScale scale{};
  scale.segment_count = 1;
  for (size_t axis = 0; axis < 3; ++axis) {
    scale.axis[axis] = (static_cast<size_t>(range.sweep_axis) + axis) % 3;
    // Segments that only other axes have do not rise. Their scale is not 0, because its product
    // with an infinity would be NaN.
    for (ByteScale::Segment& segment : scale.segments) segment.scale[axis] = 1;
    const auto& line = range.lines[axis];
    scale.segment_count = std::max(scale.segment_count, line.count);
    for (size_t s = 0; s < line.count; ++s) {
      scale.segments[s].origin[axis] = line.begin[s];
      scale.segments[s].scale[axis] = kLast * line.scale[s];
      scale.segments[s].rise[axis] = kLast * line.rise[s];
    }
    if (line.count > 0) continue;
    scale.segments[0].origin[axis] = range.low[axis];
    scale.segments[0].scale[axis] = (kLast + 1) / range.width(static_cast<int>(axis));
    scale.segments[0].rise[axis] = kLast;
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
