#include "engine_client/broad_phase/common/byte_scan.h"

#include <algorithm>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/common/byte_scan.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// The includes below must come after foreach_target.h.
#include "engine_client/broad_phase/common/box_record-inl.h"
#include "engine_client/broad_phase/common/pair_cursor.h"
#include "engine_client/broad_phase/common/stop_poll.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

using Bytes = hn::CappedTag<uint8_t, ByteBoxes::kGranule>;

// Bit k is set if the box in slot `at` + k may overlap the box in slot `row`.
struct Candidates {
  uint64_t bits;
  uint32_t row;
  uint32_t at;
};
// Capacity of the list of candidates that are collected before they are tested exactly.
constexpr size_t kCandidatesRoom = 256;

// Tests candidates exactly and writes the overlapping pairs. A box's record is at its slot, or at
// its id if kById. The loop over all bits does not branch on their number or on the results: such
// branches would often be mispredicted, which costs more than the tests. REQUIRES: two entries
// behind the last one are readable.
template <bool kById>
HWY_NOINLINE void TestExactly(const ByteLanes& lanes, const Candidates* all, size_t count,
                              PairCursor& cursor) {
  size_t total = 0;
  for (size_t k = 0; k < count; ++k) total += hwy::PopCount(all[k].bits);
  if (total == 0) return;
  OverlapPair* const out = cursor.Room(total);
  size_t found = 0;
  uint64_t bits = all[0].bits;
  // Loads the bits of the next entry one iteration ahead, so that no iteration waits for a load.
  uint64_t next_bits = all[1].bits;
  for (size_t k = 0; k < total; ++k) {
    const size_t row = all->row;
    const size_t slot = all->at + hwy::Num0BitsBelowLS1Bit_Nonzero64(bits);
    const uint32_t a = lanes.id[row];
    const uint32_t b = lanes.id[slot];
    // Puts the smaller id first; std::minmax compiles to a branch.
    const uint32_t swapped = (a ^ b) & (a > b ? ~0U : 0U);
    // Stores both ids as one 64-bit word. The compiler would combine two separate ids in a vector
    // register, which takes longer.
    const uint64_t pair = uint64_t{b ^ swapped} << 32 | (a ^ swapped);
    std::memcpy(out + found, &pair, sizeof(pair));
    found += RecordsOverlap(lanes.record[kById ? a : row], lanes.record[kById ? b : slot]) ? 1 : 0;
    // Removes the bit. After the last bit of an entry, goes to the next entry.
    bits &= bits - 1;
    const uint64_t is_last = bits == 0 ? 1 : 0;
    bits |= next_bits & (0 - is_last);
    all += is_last;
    next_bits = all[1].bits;
  }
  cursor.Advance(found);
}

// Returns the mask as bits. x86 has one instruction for this; hn::StoreMaskBits would add
// instructions that widen the result to 64 bits.
HWY_INLINE uint64_t BitsOf([[maybe_unused]] Bytes d, hn::Mask<Bytes> mask) {
#if HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86
  return mask.raw;
#elif HWY_TARGET == HWY_AVX2
  return static_cast<uint32_t>(_mm256_movemask_epi8(mask.raw));
#elif HWY_TARGET == HWY_SSE4
  return static_cast<uint32_t>(_mm_movemask_epi8(mask.raw));
#else
  uint64_t bits = 0;
  hn::StoreMaskBits(d, mask, reinterpret_cast<uint8_t*>(&bits));
  return bits;
#endif
}

// The six bytes of one box. No store can alias this copy, so that the compiler keeps it in
// registers.
struct RowBytes {
  uint8_t low[3];
  uint8_t high[3];
};

HWY_INLINE RowBytes RowAt(const ByteLanes& lanes, size_t row) {
  return {{lanes.low[0][row], lanes.low[1][row], lanes.low[2][row]},
          {lanes.high[0][row], lanes.high[1][row], lanes.high[2][row]}};
}

// Returns, as bits, which slots from `at` on may overlap `row`: their boxes have no gap on any
// axis. Swept slots are sorted by their begin on axis 0. No later slot then ends before the row
// begins, so that gap_before(0) is left out. The gaps are combined in bytes before one comparison,
// which is faster than six comparisons into masks.
template <bool kSwept>
HWY_INLINE uint64_t Compare(Bytes d, const RowBytes& row, const ByteLanes& lanes, size_t at) {
  const auto gap_before = [&](size_t axis) HWY_ATTR {
    return hn::SaturatedSub(hn::Set(d, row.low[axis]), hn::LoadU(d, lanes.high[axis] + at));
  };
  const auto gap_behind = [&](size_t axis) HWY_ATTR {
    return hn::SaturatedSub(hn::LoadU(d, lanes.low[axis] + at), hn::Set(d, row.high[axis]));
  };
  auto gap = hn::Or3(gap_behind(0), gap_before(1), gap_behind(1));
  gap = hn::Or3(gap, gap_before(2), gap_behind(2));
  if constexpr (!kSwept) gap = hn::Or(gap, gap_before(0));
  return BitsOf(d, hn::Eq(gap, hn::Zero(d)));
}

// Calls Compare for each register of the `step` slots from `at` on, and joins the bits.
template <bool kSwept>
HWY_INLINE uint64_t CompareStep(Bytes d, const RowBytes& row, const ByteLanes& lanes, size_t at,
                                size_t step) {
  uint64_t bits = Compare<kSwept>(d, row, lanes, at);
  for (size_t next = hn::Lanes(d); next < step; next += hn::Lanes(d))
    bits |= Compare<kSwept>(d, row, lanes, at + next) << next;
  return bits;
}

// Returns a mask of the slots after `row`. Bit 0 stands for slot `at`.
HWY_INLINE uint64_t BitsBehind(size_t row, size_t at) {
  if (row < at) return ~uint64_t{0};
  return row + 1 - at < 64 ? ~uint64_t{0} << (row + 1 - at) : 0;
}

// Scans tiles of kRowsPerTile rows from `row_to_scan` on. It compares each tile with kRegisters
// registers of slots at a time. Stops at `end` or after `max_checks` checks. Returns the number of
// checks and stores the next row in `row_to_scan`. Not inlined, since the caller's variables would
// occupy registers.
template <bool kSwept, bool kById, size_t kRegisters>
HWY_NOINLINE uint64_t ScanTiles(const ByteLanes& shared_lanes, size_t& row_to_scan, size_t end,
                                uint64_t max_checks, PairBuffer& out) {
  const Bytes d;
  const size_t step = std::min(kRegisters * hn::Lanes(d), ByteBoxes::kGranule);
  const ByteLanes lanes = shared_lanes;
  PairCursor cursor(out);
  Candidates candidates[kCandidatesRoom + 2] = {};
  size_t count = 0;
  const auto add = [&](uint64_t bits, size_t row, size_t at) HWY_ATTR {
    candidates[count] = {bits, static_cast<uint32_t>(row), static_cast<uint32_t>(at)};
    count += bits != 0 ? 1 : 0;
  };
  uint64_t checks = 0;
  size_t row = row_to_scan;
  for (; row < end && checks < max_checks; row += kRowsPerTile) {
    // The four rows of the tile stay in registers.
    const RowBytes row0 = RowAt(lanes, row);
    const RowBytes row1 = RowAt(lanes, row + 1);
    const RowBytes row2 = RowAt(lanes, row + 2);
    const RowBytes row3 = RowAt(lanes, row + 3);
    float tile_end = 0;
    if constexpr (kSwept)
      tile_end = *std::max_element(lanes.end + row, lanes.end + row + kRowsPerTile);
    // Compares the tile with `step` slots at a time, from the multiple of `step` at or below the
    // first row on.
    const size_t first = row / step * step;
    size_t at = first;
    for (; at < lanes.count; at += step) {
      if (kSwept && lanes.begin[at] > tile_end) break;
      uint64_t bits0 = CompareStep<kSwept>(d, row0, lanes, at, step);
      uint64_t bits1 = CompareStep<kSwept>(d, row1, lanes, at, step);
      uint64_t bits2 = CompareStep<kSwept>(d, row2, lanes, at, step);
      uint64_t bits3 = CompareStep<kSwept>(d, row3, lanes, at, step);
      // Clears, for each row, the bits of the row itself and of earlier slots.
      if (at < row + kRowsPerTile) {
        bits0 &= BitsBehind(row, at);
        bits1 &= BitsBehind(row + 1, at);
        bits2 &= BitsBehind(row + 2, at);
        bits3 &= BitsBehind(row + 3, at);
      }
      if (!kSwept && (bits0 | bits1 | bits2 | bits3) == 0) continue;
      // Collects the candidates and tests them exactly when the list is nearly full.
      add(bits0, row, at);
      add(bits1, row + 1, at);
      add(bits2, row + 2, at);
      add(bits3, row + 3, at);
      if (count <= kCandidatesRoom - kRowsPerTile) continue;
      TestExactly<kById>(lanes, candidates, count, cursor);
      count = 0;
    }
    checks += kRowsPerTile * (at - first);
  }
  // Tests the remaining candidates.
  TestExactly<kById>(lanes, candidates, count, cursor);
  cursor.Flush();
  row_to_scan = row;
  return checks;
}

template <bool kSwept, bool kById, size_t kRegisters>
uint64_t Scan(const ByteLanes& lanes, size_t begin, size_t end, PairBuffer& out,
              StopRequest* stop) {
  StopPoll poll(stop, out);
  uint64_t checks = 0;
  for (size_t row = begin; row < end && !poll.Ends(checks);) {
    const uint64_t max_checks = poll.next_question() - checks;
    checks += ScanTiles<kSwept, kById, kRegisters>(lanes, row, end, max_checks, out);
  }
  return checks;
}

// Below this number of slots² per expected pair, steps of two registers are faster than steps of
// one. With many pairs, the processor cannot predict which steps have candidates. Half as many
// steps then cost less in total, although a step of two registers costs more than two steps of one.
// Measured on AMD Zen 4 with `sweepstake-lab bench --simd avx2,sse4 --arms BruteForce`, suites b, g
// and h with 1,000 to 10,000 boxes. Other 128-bit instruction sets were not timed and use SSE4's
// value.
constexpr uint64_t kSlotsPerPair = HWY_MAX_BYTES == 32 ? 900 : 250;

uint64_t ScanAll(const ByteLanes& lanes, size_t begin, size_t end,
                 [[maybe_unused]] size_t expected_pairs, PairBuffer& out, StopRequest* stop) {
#if HWY_MAX_BYTES != 64  // with 64 bytes one register is a whole granule
  if (expected_pairs * kSlotsPerPair > uint64_t{lanes.count} * lanes.count)
    return Scan<false, false, 2>(lanes, begin, end, out, stop);
#endif
  return Scan<false, false, 1>(lanes, begin, end, out, stop);
}

uint64_t ScanSwept(const ByteLanes& lanes, size_t begin, size_t end, PairBuffer& out,
                   StopRequest* stop) {
  if (lanes.records_by_id) return Scan<true, true, 1>(lanes, begin, end, out, stop);
  return Scan<true, false, 1>(lanes, begin, end, out, stop);
}

// The times were measured with AVX-512, AVX2 and SSE4. Other instruction sets use SSE4's time.
double CheckNs() {
  constexpr double kNsOf64 = HWY_MAX_BYTES == 64 ? 1.25 : HWY_MAX_BYTES == 32 ? 2.25 : 3.6;
  return kNsOf64 / 64;
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(ScanAll);
HWY_EXPORT(ScanSwept);
HWY_EXPORT(CheckNs);

uint64_t FindPairsOfAll(const ByteLanes& lanes, size_t begin, size_t end, size_t expected_pairs,
                        PairBuffer& out, StopRequest* stop) {
  return HWY_DYNAMIC_DISPATCH(ScanAll)(lanes, begin, end, expected_pairs, out, stop);
}

uint64_t FindPairsOfSwept(const ByteLanes& lanes, size_t begin, size_t end, PairBuffer& out,
                          StopRequest* stop) {
  return HWY_DYNAMIC_DISPATCH(ScanSwept)(lanes, begin, end, out, stop);
}

double SweptCheckNs() { return HWY_DYNAMIC_DISPATCH(CheckNs)(); }

}  // namespace sweepstake

#endif  // HWY_ONCE
