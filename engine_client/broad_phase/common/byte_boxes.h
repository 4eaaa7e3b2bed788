// ByteBoxes stores boxes for scans, which compare each box with many others. Each coordinate is
// also stored as a byte, so that one register compares 64 boxes. The exact boxes are kept to test
// the remaining candidates.
//
// A monotone function q maps a coordinate to [0, 255]; it is linear over the range of most boxes,
// or piecewise linear where the boxes crowd in a few parts of it, and constant outside. a.min <=
// b.max implies q(a.min) <= q(b.max): boxes that overlap also overlap in bytes, whatever the range,
// rounding and outliers.
//
// Not thread-safe, but distinct slots may be filled at the same time. Owns its memory: 42 bytes per
// box, 50 with a sweep axis, of which 32 are the exact boxes. Cost of Fill: O(slots).
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/common/aligned_buffer.h"
#include "engine_client/broad_phase/common/box_record.h"
#include "engine_client/broad_phase/common/coordinate_range.h"
#include "sweepstake/aabb.h"

namespace sweepstake {

// Positions on the sweep axis: either exact coordinates, or coordinates rounded to whole steps from
// 0 to `last`. Rounding is monotone like q, so that a sweep over slots sorted by their steps still
// finds every pair. It only tests a few more boxes.
struct SweepAxis {
  bool exact = true;
  float low = 0;
  float scale = 1;
  float last = 0;

  // Returns the step of the coordinate x. REQUIRES: x is not NaN.
  uint32_t Step(float x) const {
    return static_cast<uint32_t>(std::min(std::max((x - low) * scale, 0.0F), last));
  }
  float Position(float x) const { return exact ? x : static_cast<float>(Step(x)); }
};

// The columns of a ByteBoxes, indexed by slot. Fill writes them and kernels read them. low[0] and
// high[0] belong to the sweep axis.
struct ByteLanes {
  uint8_t* low[3];
  uint8_t* high[3];
  // The first and last position of each slot's box on the sweep axis. The slots are sorted by
  // `begin`. Both are null without a sweep axis.
  float* begin;
  float* end;
  uint32_t* id;
  const BoxRecord* record;  // the exact boxes, indexed by slot, or by id if records_by_id
  bool records_by_id;
  size_t count;
};

class ByteBoxes {
 public:
  // The maximum number of slots that a kernel compares at a time. The slots behind the last box, up
  // to the next multiple of kGranule, hold kInvalidRecord. There is at least one such slot.
  static constexpr size_t kGranule = 64;

  // Makes room for `count` boxes and for their records, which are indexed by slot. If `swept`, it
  // also makes room for their positions on the sweep axis.
  void Resize(size_t count, bool swept);
  // Makes room for `count` swept boxes whose records the caller owns. REQUIRES: `records` is
  // indexed by id, and a kInvalidRecord follows the last one.
  void ResizeFor(const BoxRecord* records, size_t count);
  // Returns an array that holds the box id of each slot. The caller writes count() ids before Fill.
  uint32_t* ids() { return ids_.data(); }
  // Fills the slots [begin, end) from `boxes`, or from the records passed to ResizeFor. REQUIRES:
  // `begin` is a multiple of kGranule, and so is `end` unless it equals the number of boxes.
  void Fill(std::span<const Aabb> boxes, const CoordinateRange& range, const SweepAxis& axis,
            size_t begin, size_t end);
  void Fill(const CoordinateRange& range, const SweepAxis& axis, size_t begin, size_t end);

  size_t count() const { return count_; }
  // Returns a view that is valid until the next Resize.
  ByteLanes Lanes();
  size_t native_bytes() const;

 private:
  void ResizeSlots(size_t count, bool swept);
  void PadSlots();

  AlignedBuffer<BoxRecord> records_;
  // The low bytes of the three axes, beginning with the sweep axis, then the high bytes.
  AlignedBuffer<uint8_t> bytes_;
  AlignedBuffer<float> ends_;  // ByteLanes::begin, then ByteLanes::end
  AlignedBuffer<uint32_t> ids_;
  size_t count_ = 0;
  size_t stride_ = 0;
  bool swept_ = false;
  const BoxRecord* borrowed_ = nullptr;
};

}  // namespace sweepstake
