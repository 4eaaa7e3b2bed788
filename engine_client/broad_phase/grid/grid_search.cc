#include "engine_client/broad_phase/grid/grid_search.h"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/grid/grid_search.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// The includes below must come after foreach_target.h.
#include "engine_client/broad_phase/common/compress-inl.h"
#include "engine_client/broad_phase/common/overlap_kernel-inl.h"
#include "engine_client/broad_phase/common/stop_poll.h"
#include "engine_client/broad_phase/grid/grid_boxes-inl.h"

// This include guard is needed since the file is compiled once per target.
#ifndef SWEEPSTAKE_GRID_SEARCH_
#define SWEEPSTAKE_GRID_SEARCH_
namespace sweepstake {

// A list of ranges: the box in `slot` is tested against the boxes in the slots [begin, end).
struct RangeList {
  // Room for five ranges per box of a batch, and for one empty range, which is written but not
  // counted.
  static constexpr size_t kRoom = 5 * GridView::kBatch + 1;

  uint32_t slot[kRoom];
  uint32_t begin[kRoom];
  uint32_t end[kRoom];
  size_t count = 0;
};

// The number of slots in a batch, and one register that may be written behind them.
constexpr size_t kBatchRoom = GridView::kBatch + HWY_MAX_BYTES / sizeof(float);

// Fewer rows than this are read one by one.
constexpr uint32_t kManyRows = 8;

// Rows to search if the cells are as large as the boxes or larger. A box then finds its partners in
// the later boxes of its own row and in four rows of cells behind it. A row is given by its first
// cell and the cell behind its last. They are equal if the box does not reach the row.
struct BatchRows {
  static constexpr size_t kCount = 5;

  int32_t first[kCount][kBatchRoom];
  int32_t behind[kCount][kBatchRoom];
};

// Blocks of cells to search if the cells are smaller than the boxes. A block has a first and a last
// cell on three axes: x along the rows, y and z across them. In y and z the cells are relative to
// the cell of the min corner.
struct BatchBlocks {
  int32_t row[kBatchRoom];  // the first cell of the row that holds the min corner
  int32_t first_x[kBatchRoom];
  int32_t last_x[kBatchRoom];
  int32_t first_y[kBatchRoom];
  int32_t last_y[kBatchRoom];
  int32_t first_z[kBatchRoom];
  int32_t last_z[kBatchRoom];
};

}  // namespace sweepstake
#endif

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

// Computes cells on one axis for the boxes from `slot` on: the first and last cell that can hold
// the min corners of their partners, and the cell of their own min corner.
template <class D, class V>
HWY_INLINE void CellsOnAxis(D d, const BoxLanes& lanes, const GroupGrid& grid, size_t axis,
                            size_t slot, V& first, V& own, V& last) {
  const auto half = hn::Set(d, 0.5F);
  const auto min = hn::Mul(hn::LoadU(d, lanes.min[axis] + slot), half);
  const auto max = hn::Mul(hn::LoadU(d, lanes.max[axis] + slot), half);
  first = CellsAt(d, grid, axis, hn::Sub(min, hn::Set(d, grid.reach[axis])));
  own = CellsAt(d, grid, axis, min);
  last = CellsAt(d, grid, axis, max);
}

// Computes which cells of `grid` to search for the boxes in the slots [begin, end).
void FindBlocks(const BoxLanes& lanes, const GroupGrid& grid, size_t begin, size_t end,
                BatchBlocks& blocks) {
  const HWY_FULL(float) d;
  const hn::RebindToSigned<decltype(d)> di;
  const size_t x_axis = grid.AxisOf(0);
  const size_t y_axis = grid.AxisOf(1);
  const size_t z_axis = grid.AxisOf(2);
  const auto y_stride = hn::Set(di, static_cast<int32_t>(grid.stride[y_axis]));
  const auto z_stride = hn::Set(di, static_cast<int32_t>(grid.stride[z_axis]));
  const auto first_cell = hn::Set(di, static_cast<int32_t>(grid.first_cell));
  for (size_t slot = begin; slot < end; slot += hn::Lanes(d)) {
    const size_t k = slot - begin;
    // Stores x cells as absolute numbers, and y and z cells relative to the cell of the min corner.
    auto first = hn::Zero(di);
    auto own = first;
    auto last = first;
    CellsOnAxis(d, lanes, grid, x_axis, slot, first, own, last);
    hn::StoreU(first, di, blocks.first_x + k);
    hn::StoreU(last, di, blocks.last_x + k);
    CellsOnAxis(d, lanes, grid, y_axis, slot, first, own, last);
    hn::StoreU(hn::Sub(first, own), di, blocks.first_y + k);
    hn::StoreU(hn::Sub(last, own), di, blocks.last_y + k);
    auto row = hn::Add(first_cell, hn::Mul(own, y_stride));
    CellsOnAxis(d, lanes, grid, z_axis, slot, first, own, last);
    hn::StoreU(hn::Sub(first, own), di, blocks.first_z + k);
    hn::StoreU(hn::Sub(last, own), di, blocks.last_z + k);
    hn::StoreU(hn::Add(row, hn::Mul(own, z_stride)), di, blocks.row + k);
  }
}

// Stores the row that begins `offset` cells behind the box's own row, or an empty row if the offset
// is 0.
template <class D, class V>
HWY_INLINE void StoreRow(D di, V first, V behind, V offset, size_t row, size_t k, BatchRows& rows) {
  const auto wanted = hn::Ne(offset, hn::Zero(di));
  behind = hn::Add(behind, offset);
  hn::StoreU(hn::IfThenElse(wanted, hn::Add(first, offset), behind), di, rows.first[row] + k);
  hn::StoreU(behind, di, rows.behind[row] + k);
}

// Computes which rows of `grid` to search for the boxes in the slots [begin, end). Returns false if
// a box is longer than a cell in y or z, the axes across the rows.
bool FindRows(const BoxLanes& lanes, const GroupGrid& grid, size_t begin, size_t end,
              BatchRows& rows) {
  const HWY_FULL(float) d;
  const hn::RebindToSigned<decltype(d)> di;
  const size_t y_axis = grid.AxisOf(1);
  const size_t z_axis = grid.AxisOf(2);
  const auto one = hn::Set(di, 1);
  const auto y_stride = hn::Set(di, static_cast<int32_t>(grid.stride[y_axis]));
  const auto z_stride = hn::Set(di, static_cast<int32_t>(grid.stride[z_axis]));
  const auto first_cell = hn::Set(di, static_cast<int32_t>(grid.first_cell));
  auto max_reach = hn::Zero(di);
  for (size_t slot = begin; slot < end; slot += hn::Lanes(d)) {
    const size_t k = slot - begin;
    // Finds the min corner's row, and how many rows the box reaches up and down (y).
    auto first_x = hn::Zero(di);
    auto own = first_x;
    auto last_x = first_x;
    CellsOnAxis(d, lanes, grid, grid.AxisOf(0), slot, first_x, own, last_x);
    auto first_y = first_x;
    auto last_y = first_x;
    CellsOnAxis(d, lanes, grid, y_axis, slot, first_y, own, last_y);
    auto row = hn::Add(first_cell, hn::Mul(own, y_stride));
    const auto up = hn::Sub(last_y, own);
    const auto down = hn::Sub(own, first_y);
    // Adds the row's offset along z, and finds how many rows the box reaches in z.
    auto unused = first_x;
    auto last_z = first_x;
    CellsOnAxis(d, lanes, grid, z_axis, slot, unused, own, last_z);
    row = hn::Add(row, hn::Mul(own, z_stride));
    const auto beyond = hn::Sub(last_z, own);
    max_reach = hn::Max(max_reach, hn::Max(beyond, hn::Max(up, down)));
    // Stores the end of the box's own row: the cell behind the last one to search. The start of the
    // row is not stored, since the search in this row begins at the slot behind the box.
    const auto first = hn::Add(row, first_x);
    const auto behind = hn::Add(hn::Add(row, last_x), one);
    hn::StoreU(behind, di, rows.behind[0] + k);
    // Stores the four neighbouring rows that follow the box's own row in cell order. The values up,
    // down and beyond are 0 or 1; if any is larger, the caller discards the result.
    StoreRow(di, first, behind, hn::Mul(up, y_stride), 1, k, rows);
    StoreRow(di, first, behind, hn::Mul(hn::And(beyond, down), hn::Sub(z_stride, y_stride)), 2, k,
             rows);
    StoreRow(di, first, behind, hn::Mul(beyond, z_stride), 3, k, rows);
    StoreRow(di, first, behind, hn::Mul(hn::And(beyond, up), hn::Add(z_stride, y_stride)), 4, k,
             rows);
  }
  return hn::AllFalse(di, hn::Gt(max_reach, one));
}

// Stores the pairs of `id` with the ids of the hit lanes and returns their number, like StoreHits
// (overlap_kernel-inl.h). Stores the second half of the pairs only if needed, which is rare. With
// StorePairs this search would take a quarter longer: StorePairs needs a mask register, and AVX-512
// has none free in this loop.
template <class D>
HWY_INLINE size_t StoreFewHits(D d, hn::Mask<D> hits, uint32_t id, const uint32_t* ids,
                               OverlapPair* out) {
#if HWY_TARGET == HWY_SCALAR
  return StoreHits(d, hits, id, ids, out);
#else
  const hn::RebindToUnsigned<D> du;
  const hn::Half<decltype(du)> dh;
  const hn::RepartitionToWide<decltype(du)> dw;
  const auto others = CompressLanes(hn::LoadU(du, ids), hn::RebindMask(du, hits));
  const auto self = hn::Set(du, id);
  const auto a = hn::Min(self, others);
  const auto b = hn::Max(self, others);
  const auto pairs = hn::Or(hn::PromoteTo(dw, hn::LowerHalf(dh, a)),
                            hn::ShiftLeft<32>(hn::PromoteTo(dw, hn::LowerHalf(dh, b))));
  hn::StoreU(hn::BitCast(du, pairs), du, &out->a);
  const size_t count = hn::CountTrue(d, hits);
  if (HWY_UNLIKELY(count > hn::Lanes(dh))) {
    const auto more = hn::Or(hn::PromoteTo(dw, hn::UpperHalf(dh, a)),
                             hn::ShiftLeft<32>(hn::PromoteTo(dw, hn::UpperHalf(dh, b))));
    hn::StoreU(hn::BitCast(du, more), du, &out[hn::Lanes(dh)].a);
  }
  return count;
#endif
}

// Returns the lanes from slot `at` on that overlap `box`. The columns are one stride apart, so that
// two registers address all six. Six pointers would leave no registers for the box.
template <class D>
HWY_INLINE hn::Mask<D> HitsInColumns(D d, const Aabb& box, const float* columns, size_t stride,
                                     size_t at) {
  const float* const min = columns + at;
  const float* const max = min + 3 * stride;
  const auto x = hn::And(hn::Le(hn::LoadU(d, min), hn::Set(d, box.max[0])),
                         hn::Ge(hn::LoadU(d, max), hn::Set(d, box.min[0])));
  const auto y = hn::And(hn::Le(hn::LoadU(d, min + stride), hn::Set(d, box.max[1])),
                         hn::Ge(hn::LoadU(d, max + stride), hn::Set(d, box.min[1])));
  const auto z = hn::And(hn::Le(hn::LoadU(d, min + 2 * stride), hn::Set(d, box.max[2])),
                         hn::Ge(hn::LoadU(d, max + 2 * stride), hn::Set(d, box.min[2])));
  return hn::And(hn::And(x, y), z);
}

// Tests all ranges of a list and returns the number of AABB checks. `checks_before` is the number
// of checks made before this call.
HWY_INLINE uint64_t TestRanges(const BoxLanes& lanes, const RangeList& list, PairBuffer& out,
                               StopPoll& poll, uint64_t checks_before) {
  const HWY_FULL(float) d;
  const size_t step = hn::Lanes(d);
  constexpr size_t kChunk = 1024;
  // The corners of all slots lie in six columns with one stride between them.
  const float* const columns = lanes.min[0];
  const auto stride = static_cast<size_t>(lanes.min[1] - lanes.min[0]);
  const uint32_t* const ids = lanes.id;
  // Pairs are stored without checking for room until a chunk of the pair buffer is full.
  OverlapPair* from = out.EnsureRoom(kChunk);
  OverlapPair* to = from;
  const OverlapPair* full = from + kChunk;
  uint64_t checks = 0;
  const size_t count = list.count;
  for (size_t k = 0; k < count; ++k) {
    // Loads the box that is tested against the range. It stays in registers.
    const uint32_t slot = list.slot[k];
    const float* const own = columns + slot;
    const Aabb box = {{own[0], own[stride], own[2 * stride]},
                      {own[3 * stride], own[4 * stride], own[5 * stride]}};
    const uint32_t id = ids[slot];
    const size_t end = list.end[k];
    size_t at = list.begin[k];
    // Tests the slots of the range, which is never empty, a register at a time.
    do {
      if (HWY_UNLIKELY(to >= full)) {
        out.Advance(static_cast<size_t>(to - from));
        if (poll.Ends(checks_before + checks)) return checks;
        from = to = out.EnsureRoom(kChunk);
        full = from + kChunk;
      }
      const auto hits =
          hn::And(hn::FirstN(d, end - at), HitsInColumns(d, box, columns, stride, at));
      to += StoreFewHits(d, hits, id, ids + at, to);
      checks += step;
      at += step;
    } while (at < end);
  }
  // Commits the pairs of the last chunk.
  out.Advance(static_cast<size_t>(to - from));
  return checks;
}

class BatchSearch {
 public:
  BatchSearch(const GridView& view, PairBuffer& out, StopRequest* stop)
      : view_(view), lanes_(view.lanes), in_grids_(view.in_grids), out_(out), poll_(stop, out) {}

  uint64_t checks() const { return checks_; }
  bool Ends() { return poll_.Ends(checks_); }

  // Tests the boxes in the slots [begin, end) against the later boxes of their group.
  void SearchOwn(const GroupGrid& grid, size_t begin, size_t end) {
    if (FindRows(in_grids_, grid, begin, end, rows_)) {
      ListFiveRows(begin, end);
    } else {
      FindBlocks(in_grids_, grid, begin, end, blocks_);
      for (size_t slot = begin; slot < end; ++slot) ListLaterRows(grid, slot - begin, slot);
    }
    Test();
  }

  // Tests the boxes in the slots [begin, end) against the boxes of another group, which has this
  // grid.
  void SearchOther(const GroupGrid& grid, size_t begin, size_t end) {
    FindBlocks(in_grids_, grid, begin, end, blocks_);
    for (size_t slot = begin; slot < end; ++slot) {
      const size_t k = slot - begin;
      const BlockStart start{blocks_.first_z[k], blocks_.first_y[k]};
      if (ListAsOne(grid, k, slot, start, blocks_.last_z[k], FirstSlot(grid, k, start))) continue;
      for (int32_t z = blocks_.first_z[k]; z <= blocks_.last_z[k]; ++z) ListSlab(grid, k, slot, z);
    }
    Test();
  }

 private:
  HWY_INLINE void ListFiveRows(size_t begin, size_t end) {
    const uint32_t* const starts = view_.starts;
    size_t count = 0;
    for (size_t slot = begin; slot < end; ++slot) {
      const size_t k = slot - begin;
      count = List(count, slot, static_cast<uint32_t>(slot + 1), starts[rows_.behind[0][k]]);
      for (size_t row = 1; row < BatchRows::kCount; ++row) {
        count = List(count, slot, starts[rows_.first[row][k]], starts[rows_.behind[row][k]]);
      }
    }
    list_.count = count;
  }

  // Lists a range unless it is empty, without a branch, and returns the new count.
  HWY_INLINE size_t List(size_t count, size_t slot, uint32_t begin, uint32_t end) {
    list_.slot[count] = static_cast<uint32_t>(slot);
    list_.begin[count] = begin;
    list_.end[count] = end;
    return count + static_cast<size_t>(begin < end);
  }

  // The row of a block of cells from which on it is searched, relative to the row of the min
  // corner.
  struct BlockStart {
    int32_t z;
    int32_t y;
  };

  // Returns the cells of the row at `at`. They may be indexed by x.
  const uint32_t* RowAt(const GroupGrid& grid, size_t k, BlockStart at) const {
    const auto y_stride = static_cast<int32_t>(grid.stride[grid.AxisOf(1)]);
    const auto z_stride = static_cast<int32_t>(grid.stride[grid.AxisOf(2)]);
    return view_.starts + (blocks_.row[k] + at.z * z_stride + at.y * y_stride);
  }
  uint32_t FirstSlot(const GroupGrid& grid, size_t k, BlockStart at) const {
    return RowAt(grid, k, at)[blocks_.first_x[k]];
  }

  // Lists the later boxes in the row of the box in `slot`, and the later rows of its block. This
  // function and ListSlab are not inlined, because they would take registers from the tests of
  // ranges: suite-g then takes 5 % longer with AVX2.
  HWY_NOINLINE void ListLaterRows(const GroupGrid& grid, size_t k, size_t slot) {
    const auto behind = static_cast<uint32_t>(slot + 1);
    if (ListAsOne(grid, k, slot, {0, 0}, blocks_.last_z[k], behind)) return;
    const uint32_t end = view_.starts[blocks_.row[k] + blocks_.last_x[k] + 1];
    MakeRoom();
    list_.count = List(list_.count, slot, behind, end);
    ListRows(grid, k, slot, {0, 1});
    for (int32_t z = 1; z <= blocks_.last_z[k]; ++z) ListSlab(grid, k, slot, z);
  }

  // Lists the rows of the box's block of cells at this z.
  HWY_NOINLINE void ListSlab(const GroupGrid& grid, size_t k, size_t slot, int32_t z) {
    const BlockStart start{z, blocks_.first_y[k]};
    if (!ListAsOne(grid, k, slot, start, z, FirstSlot(grid, k, start))) {
      ListRows(grid, k, slot, start);
    }
  }

  // If the box's block of cells has many rows from `start` to `last_z`, but few boxes lie between
  // the slot `begin` and the last of these cells, lists them as one range and returns true. The
  // range also holds boxes between the rows, but testing these costs less than reading the rows.
  HWY_INLINE bool ListAsOne(const GroupGrid& grid, size_t k, size_t slot, BlockStart start,
                            int32_t last_z, uint32_t begin) {
    const auto rows =
        static_cast<uint32_t>((last_z - start.z + 1) * (blocks_.last_y[k] - start.y + 1));
    if (HWY_LIKELY(rows < kManyRows)) return false;
    const uint32_t* const last = RowAt(grid, k, {last_z, blocks_.last_y[k]});
    const uint32_t end = last[blocks_.last_x[k] + 1];
    if (end > begin + kTestsPerRow * rows) return false;
    MakeRoom();
    list_.count = List(list_.count, slot, begin, end);
    return true;
  }

  // Lists the rows of the box's block of cells at the z of `start`, from its y on.
  HWY_INLINE void ListRows(const GroupGrid& grid, size_t k, size_t slot, BlockStart start) {
    for (int32_t y = start.y; y <= blocks_.last_y[k]; ++y) {
      const uint32_t* const row = RowAt(grid, k, {start.z, y});
      MakeRoom();
      list_.count = List(list_.count, slot, row[blocks_.first_x[k]], row[blocks_.last_x[k] + 1]);
    }
  }

  void MakeRoom() {
    if (list_.count + 1 >= RangeList::kRoom) Test();
  }

  void Test() {
    if (!poll_.has_ended()) checks_ += TestRanges(lanes_, list_, out_, poll_, checks_);
    list_.count = 0;
  }

  const GridView& view_;
  // No store can alias these copies, so that the compiler keeps their pointers in registers.
  const BoxLanes lanes_;
  const BoxLanes in_grids_;
  PairBuffer& out_;
  StopPoll poll_;
  uint64_t checks_ = 0;
  BatchRows rows_;
  BatchBlocks blocks_;
  RangeList list_;
};

uint64_t Search(const GridView& view, size_t begin, size_t end, PairBuffer& out,
                StopRequest* stop) {
  BatchSearch search(view, out, stop);
  for (size_t batch = begin; batch < end && !search.Ends(); batch += GridView::kBatch) {
    const size_t batch_end = std::min(batch + GridView::kBatch, end);
    for (size_t g = 0; g < view.grids.size(); ++g) {
      const GroupGrid& grid = view.grids[g];
      const size_t first = std::max<size_t>(batch, view.starts[grid.first_cell]);
      const size_t last = std::min<size_t>(batch_end, view.starts[grid.last_cell()]);
      if (first >= last) continue;
      search.SearchOwn(grid, first, last);
      for (size_t h = 0; h < view.grids.size(); ++h) {
        if ((view.searches[g] >> h & 1) != 0) search.SearchOther(view.grids[h], first, last);
      }
    }
  }
  return search.checks();
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {

HWY_EXPORT(Search);

uint64_t SearchGrids(const GridView& view, size_t begin, size_t end, PairBuffer& out,
                     StopRequest* stop) {
  return HWY_DYNAMIC_DISPATCH(Search)(view, begin, end, out, stop);
}

}  // namespace sweepstake

#endif  // HWY_ONCE
