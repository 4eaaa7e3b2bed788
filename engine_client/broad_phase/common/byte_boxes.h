// Boxes for scans over very many of them: each coordinate once more in a byte, so that one register
// compares 64 boxes, and the exact boxes for what then is left.
//
// A coordinate x becomes q(x) in 0 to 255 by one monotone function, linear over the range where
// most boxes lie and constant outside. a.min <= b.max implies q(a.min) <= q(b.max): boxes that
// overlap do so in bytes too, whatever the range, rounding and outliers.
//
// Not thread-safe, but distinct slots may be filled at the same time. Owns its memory: 42 bytes per
// box, swept ones 50, of which 32 are the exact boxes. Cost of Fill: 2 to 4 ns per box.
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

// Where boxes lie on the sweep axis: as exactly as floats do, or in whole steps from 0 to `last`,
// which are monotone like q. Slots need only be sorted by their position: a sweep in steps looks at
// a few boxes more and is still right.
struct SweepAxis {
  bool exact = true;
  float low = 0;
  float scale = 1;
  float last = 0;

  // REQUIRES: x is not NaN.
  uint32_t Step(float x) const {
    return static_cast<uint32_t>(std::min(std::max((x - low) * scale, 0.0F), last));
  }
  float Position(float x) const { return exact ? x : static_cast<float>(Step(x)); }
};

// The slots of a ByteBoxes; the first axis is the sweep axis. What a kernel reads, and what Fill
// writes.
struct ByteLanes {
  uint8_t* low[3];
  uint8_t* high[3];
  // Where a slot begins and ends on the sweep axis; `begin` ascends. Null where nothing sweeps.
  float* begin;
  float* end;
  uint32_t* id;
  const BoxRecord* record;  // by slot, or by id
  bool records_by_id;
  size_t count;
};

class ByteBoxes {
 public:
  // No kernel compares more slots at a time. Behind the last box, up to the next multiple, at least
  // one slot holds kAbsentBox.
  static constexpr size_t kGranule = 64;

  // Room for `count` boxes whose records are kept by slot; `swept` ones have a begin and an end.
  void Resize(size_t count, bool swept);
  // The same for swept boxes whose records are borrowed, by id and with a kAbsentBox behind them.
  void ResizeFor(const BoxRecord* records, size_t count);
  // Which box a slot takes: for the caller to fill, count() of them, before Fill.
  uint32_t* ids() { return ids_.data(); }
  // Slots [begin, end) take their boxes, from `boxes` or else from the borrowed records. REQUIRES:
  // begin, and end unless it is the count, are multiples of kGranule.
  void Fill(std::span<const Aabb> boxes, const CoordinateRange& range, const SweepAxis& axis,
            size_t begin, size_t end);
  void Fill(const CoordinateRange& range, const SweepAxis& axis, size_t begin, size_t end);

  size_t count() const { return count_; }
  // Valid until the next Resize.
  ByteLanes Lanes();
  size_t native_bytes() const;

 private:
  void ResizeSlots(size_t count, bool swept);
  void PadSlots();

  AlignedBuffer<BoxRecord> records_;
  AlignedBuffer<uint8_t> bytes_;  // low of the three axes from the sweep axis on, high of them
  AlignedBuffer<float> ends_;     // begin, end
  AlignedBuffer<uint32_t> ids_;
  size_t count_ = 0;
  size_t stride_ = 0;
  bool swept_ = false;
  const BoxRecord* borrowed_ = nullptr;
};

}  // namespace sweepstake
