#include "engine_client/broad_phase/grid.h"

#include <algorithm>
#include <limits>

#include "engine_client/broad_phase/grid_layout.h"
#include "engine_client/broad_phase/large_boxes.h"
#include "engine_client/broad_phase/soa_boxes.h"

// Seen by every target's pass of this file, hence guarded.
#ifndef SWEEPSTAKE_GRID_CELLS_
#define SWEEPSTAKE_GRID_CELLS_
namespace sweepstake {

// A key is cell · 8 + reach: whether the box reaches into the next cell on each axis.
constexpr int kReachBits = 3;
constexpr uint32_t kReachesX = 1;
constexpr uint32_t kReachesY = 2;
constexpr uint32_t kReachesZ = 4;

struct CellView {
  const uint32_t* starts;  // per cell of the bordered grid: its first slot; one more at the end
  const uint8_t* reach;    // per slot
  const GridLayout* layout;
};

}  // namespace sweepstake
#endif

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/grid.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// After foreach_target.h.
#include "engine_client/broad_phase/grid_cells-inl.h"
#include "engine_client/broad_phase/overlap_kernel-inl.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {

// Keys of all boxes: those too long for their cells get the cell behind the last, absent ones the
// one behind that.
void AssignCells(const BoxLanes& lanes, const GridLayout& layout, uint32_t* keys) {
  const HWY_FULL(float) d;
  const hn::RebindToSigned<decltype(d)> di;
  const hn::RebindToUnsigned<decltype(d)> du;
  const auto infinity = hn::Set(d, std::numeric_limits<float>::infinity());
  const int32_t strides[3] = {1, static_cast<int32_t>(layout.row_cells()),
                              static_cast<int32_t>(layout.slab_cells())};
  const int32_t behind = static_cast<int32_t>(layout.bordered_cells());
  for (size_t at = 0; at < lanes.count; at += hn::Lanes(d)) {
    auto cell = hn::Zero(di);
    auto reach = hn::Zero(di);
    auto longest = hn::Zero(di);
    for (size_t axis = 0; axis < 3; ++axis) {
      const auto first = CellsOf(d, layout, axis, lanes.min[axis] + at);
      const auto span = hn::Sub(CellsOf(d, layout, axis, lanes.max[axis] + at), first);
      cell = hn::Add(cell, hn::Mul(hn::Add(first, hn::Set(di, 1)), hn::Set(di, strides[axis])));
      reach = hn::Or(reach, hn::ShiftLeftSame(span, static_cast<int>(axis)));
      longest = hn::Max(longest, span);
    }
    const auto large = hn::Gt(longest, hn::Set(di, 1));
    const auto absent = hn::RebindMask(di, hn::Eq(hn::LoadU(d, lanes.min[0] + at), infinity));
    cell = hn::IfThenElse(large, hn::Set(di, behind), cell);
    cell = hn::IfThenElse(absent, hn::Set(di, behind + 1), cell);
    reach = hn::And(reach, hn::Set(di, 7));
    const auto key = hn::Or(hn::ShiftLeft<kReachBits>(cell), reach);
    hn::StoreU(hn::BitCast(du, key), du, keys + at);
  }
}

// One box against the later boxes of its cell and the half of the cells around it that follows.
template <class D>
HWY_INLINE uint64_t ScanAround(D d, const BoxLanes& lanes, const CellView& view, size_t cell,
                               size_t slot, PairCursor& cursor) {
  const uint32_t* const starts = view.starts;
  const size_t row = view.layout->row_cells();
  const size_t slab = view.layout->slab_cells();
  const uint32_t reach = view.reach[slot];
  const size_t past_x = 1 + (reach & kReachesX);
  const Aabb box = BoxAt(lanes, slot);
  const uint32_t id = lanes.id[slot];
  const auto scan_row = [&](size_t middle) HWY_ATTR {
    return ScanRange(d, box, id, lanes, starts[middle - 1], starts[middle + past_x], cursor);
  };
  uint64_t checks = ScanRange(d, box, id, lanes, slot + 1, starts[cell + past_x], cursor);
  if ((reach & kReachesY) != 0) checks += scan_row(cell + row);
  if ((reach & kReachesZ) != 0) {
    checks += scan_row(cell + slab - row);
    checks += scan_row(cell + slab);
    if ((reach & kReachesY) != 0) checks += scan_row(cell + slab + row);
  }
  return checks;
}

uint64_t ScanCells(const BoxLanes& lanes, const CellView& view, PairBuffer& out) {
  const HWY_FULL(float) d;
  const BoxLanes local = lanes;
  const size_t row_cells = view.layout->row_cells();
  const size_t cells = view.layout->bordered_cells();
  PairCursor cursor(out);
  uint64_t checks = 0;
  for (size_t row = 0; row < cells; row += row_cells) {
    if (view.starts[row] == view.starts[row + row_cells]) continue;
    for (size_t cell = row; cell < row + row_cells; ++cell) {
      for (size_t slot = view.starts[cell]; slot < view.starts[cell + 1]; ++slot) {
        checks += ScanAround(d, local, view, cell, slot, cursor);
      }
    }
  }
  cursor.Flush();
  return checks;
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {
namespace {

HWY_EXPORT(AssignCells);
HWY_EXPORT(ScanCells);

class Grid final : public BroadPhase {
 public:
  explicit Grid(const BroadPhaseOptions& /*options*/) {}
  std::string_view name() const override { return "Grid"; }
  uint32_t version() const override { return 1; }
  void Build(std::span<const Aabb> boxes) override { Take(boxes); }
  void Update(std::span<const Aabb> boxes) override { Take(boxes); }
  void FindPairs(PairBuffer& out) override;
  uint64_t aabb_check_count() const override { return checks_; }
  size_t native_bytes() const override;

 private:
  void Take(std::span<const Aabb> boxes);
  void SortIntoCells(size_t count);

  SoaBoxes input_;   // in the caller's order
  SoaBoxes sorted_;  // by cell; then the large boxes, then the absent ones
  AlignedBuffer<uint32_t> keys_;
  AlignedBuffer<uint32_t> order_;
  AlignedBuffer<uint8_t> reach_;
  AlignedBuffer<uint32_t> starts_;
  BoxSpread spread_;
  GridLayout layout_;
  uint64_t checks_ = 0;
};

void Grid::Take(std::span<const Aabb> boxes) {
  checks_ = 0;
  input_.Gather(boxes);
  MeasureSpread(input_.Lanes(), spread_);
  layout_ =
      LayOutGrid(input_.Lanes(), spread_, ChooseOrdinarySide(spread_), 8 * boxes.size() + 512);
  keys_.EnsureDiscarding(boxes.size() + SoaBoxes::kPadding);
  HWY_DYNAMIC_DISPATCH(AssignCells)(input_.Lanes(), layout_, keys_.data());
  SortIntoCells(boxes.size());
  sorted_.Gather(boxes, {order_.data(), boxes.size()});
}

// Counting sort. Counts stand two places up, so that after the scatter starts_[c] is where cell c
// starts.
void Grid::SortIntoCells(size_t count) {
  const size_t cells = layout_.bordered_cells() + 2;
  starts_.EnsureDiscarding(cells + 2);
  order_.EnsureDiscarding(count);
  reach_.EnsureDiscarding(count);
  std::fill_n(starts_.data(), cells + 2, 0U);
  for (size_t i = 0; i < count; ++i) ++starts_[(keys_[i] >> kReachBits) + 2];
  for (size_t cell = 2; cell < cells + 2; ++cell) starts_[cell] += starts_[cell - 1];
  for (size_t i = 0; i < count; ++i) {
    const uint32_t slot = starts_[(keys_[i] >> kReachBits) + 1]++;
    order_[slot] = static_cast<uint32_t>(i);
    reach_[slot] = static_cast<uint8_t>(keys_[i] & ((1U << kReachBits) - 1));
  }
}

void Grid::FindPairs(PairBuffer& out) {
  const CellView view{starts_.data(), reach_.data(), &layout_};
  const size_t behind = layout_.bordered_cells();
  checks_ = HWY_DYNAMIC_DISPATCH(ScanCells)(sorted_.Lanes(), view, out);
  checks_ += FindPairsOfLast(sorted_.Lanes(), starts_[behind], starts_[behind + 1], out);
}

size_t Grid::native_bytes() const {
  return input_.native_bytes() + sorted_.native_bytes() + keys_.capacity_bytes() +
         order_.capacity_bytes() + reach_.capacity_bytes() + starts_.capacity_bytes();
}

}  // namespace

std::unique_ptr<BroadPhase> MakeGrid(const BroadPhaseOptions& options) {
  return std::make_unique<Grid>(options);
}

}  // namespace sweepstake

#endif  // HWY_ONCE
