#include "engine_client/broad_phase/tracy.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine_client/broad_phase/cell_lists.h"
#include "engine_client/broad_phase/grid_layout.h"
#include "engine_client/broad_phase/large_boxes.h"
#include "engine_client/broad_phase/soa_boxes.h"
#include "engine_client/broad_phase/tracy_ranges.h"
#include "engine_client/broad_phase/tracy_sweep.h"

namespace sweepstake {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr Aabb kSentinel = {{kInfinity, kInfinity, kInfinity},
                            {-kInfinity, -kInfinity, -kInfinity}};

// Cell side in ordinary boxes: smaller cells hold the boxes they share more often, larger ones more
// boxes to sweep.
constexpr float kSidesPerCell = 2;
// Boxes per cell below which cells cost more than they save.
constexpr size_t kLeastBoxesPerCell = 2;
// A grid always gets as many if it can use them (LayOutGrid).
constexpr size_t kLeastCells = 512;
// Boxes whose ranges are found at a time: they stay in the first cache.
constexpr size_t kBatch = 256;
// About what laying out anew costs.
constexpr uint64_t kChecksPerLayout = 256;

class Tracy final : public BroadPhase {
 public:
  explicit Tracy(const BroadPhaseOptions& /*options*/) {}
  std::string_view name() const override { return "Tracy"; }
  uint32_t version() const override { return 1; }
  void Build(std::span<const Aabb> boxes) override;
  void Update(std::span<const Aabb> boxes) override;
  void FindPairs(PairBuffer& out) override;
  uint64_t aabb_check_count() const override { return checks_; }
  size_t native_bytes() const override;

 private:
  SweepInput Input() const { return {{boxes_.data(), count_}, layout_, sweep_axis_}; }
  // Of any layout for as many boxes.
  size_t MostCells() const { return std::max(kLeastCells, count_ / kLeastBoxesPerCell); }
  void LayOut(std::span<const Aabb> boxes);
  void FillLists();
  void TakeBatch(std::span<const Aabb> boxes, size_t begin);
  void EnterCells(uint32_t object, const CellRange& from, const CellRange& to);
  uint64_t FindPairsOfLarge(PairBuffer& out);

  // Calls action(cell) for each cell of the range.
  template <class Action>
  void ForEachCell(const CellRange& range, const Action& action) const {
    const CellPosition first = PositionOf(layout_, range.first);
    const CellPosition last = PositionOf(layout_, range.last);
    for (uint32_t z = first.at[2]; z <= last.at[2]; ++z) {
      for (uint32_t y = first.at[1]; y <= last.at[1]; ++y) {
        for (uint32_t x = first.at[0]; x <= last.at[0]; ++x) action(CellPosition{{x, y, z}});
      }
    }
  }

  AlignedBuffer<Aabb> boxes_;
  AlignedBuffer<CellRange> ranges_;
  size_t count_ = 0;
  GridLayout layout_;
  size_t sweep_axis_ = 0;
  CellLists lists_;
  bool tidy_ = true;  // the lists hold what the ranges say, and nothing else
  size_t large_count_ = 0;

  SweepRoom room_;
  SoaBoxes batch_;
  AlignedBuffer<CellRange> batch_ranges_;
  AlignedBuffer<uint32_t> sizes_;
  AlignedBuffer<uint32_t> large_order_;
  SoaBoxes large_lanes_;

  uint64_t fewest_checks_ = 0;  // in a frame since the grid was laid out
  uint64_t excess_checks_ = 0;  // above that, since then
  uint64_t checks_ = 0;
};

void Tracy::Build(std::span<const Aabb> boxes) {
  count_ = boxes.size();
  checks_ = 0;
  boxes_.EnsureDiscarding(count_);
  ranges_.EnsureDiscarding(count_ + SoaBoxes::kPadding);
  batch_ranges_.EnsureDiscarding(kBatch + SoaBoxes::kPadding);
  LayOut(boxes);
  FillLists();
  fewest_checks_ = std::numeric_limits<uint64_t>::max();
  excess_checks_ = 0;
}

void Tracy::LayOut(std::span<const Aabb> boxes) {
  // All boxes at once: the lanes of the large ones serve.
  large_lanes_.Gather(boxes);
  const BoxLanes lanes = large_lanes_.Lanes();
  BoxSpread spread;
  MeasureSpread(lanes, spread);
  const float side =
      std::min(kSidesPerCell * ChooseOrdinarySide(spread), std::numeric_limits<float>::max());
  layout_ = LayOutGrid(lanes, spread, side, MostCells());
  const auto widest = std::max_element(layout_.cells, layout_.cells + 3);
  sweep_axis_ = static_cast<size_t>(widest - layout_.cells);
  FindRanges(lanes, layout_, ranges_.data());
  std::copy(boxes.begin(), boxes.end(), boxes_.data());
  large_count_ = 0;
  for (size_t i = 0; i < count_; ++i) {
    if (ranges_[i].first == CellRange::kAbsent) boxes_[i] = kSentinel;
    large_count_ += ranges_[i].first == CellRange::kLarge ? 1 : 0;
  }
}

void Tracy::FillLists() {
  const size_t cells = CellCount(layout_);
  sizes_.EnsureDiscarding(MostCells());
  std::fill_n(sizes_.data(), cells, 0U);
  for (size_t i = 0; i < count_; ++i) {
    if (!ranges_[i].IsInCells()) continue;
    ForEachCell(ranges_[i], [&](const CellPosition& at) { ++sizes_[NumberOf(layout_, at)]; });
  }
  lists_.Reset({sizes_.data(), cells}, MostCells());
  constexpr CellRange kNowhere{CellRange::kAbsent, CellRange::kAbsent};
  for (uint32_t i = 0; i < count_; ++i) EnterCells(i, kNowhere, ranges_[i]);
  tidy_ = true;
}

void Tracy::Update(std::span<const Aabb> boxes) {
  if (boxes.size() != count_) return Build(boxes);
  checks_ = 0;
  if (excess_checks_ > kChecksPerLayout * count_) {
    Build(boxes);
    return;
  }
  // Otherwise a box that left a cell and comes back would be in its list twice.
  if (!tidy_) TidyCells(Input(), lists_, room_);
  tidy_ = false;
  large_count_ = 0;
  for (size_t begin = 0; begin < count_; begin += kBatch) {
    TakeBatch(boxes.subspan(begin, std::min(kBatch, count_ - begin)), begin);
  }
}

void Tracy::TakeBatch(std::span<const Aabb> boxes, size_t begin) {
  batch_.Gather(boxes);
  FindRanges(batch_.Lanes(), layout_, batch_ranges_.data());
  std::copy(boxes.begin(), boxes.end(), boxes_.data() + begin);
  for (size_t k = 0; k < boxes.size(); ++k) {
    const CellRange range = batch_ranges_[k];
    CellRange& kept = ranges_[begin + k];
    if (range.first == CellRange::kAbsent) boxes_[begin + k] = kSentinel;
    large_count_ += range.first == CellRange::kLarge ? 1 : 0;
    if (range == kept) continue;
    EnterCells(static_cast<uint32_t>(begin + k), kept, range);
    kept = range;
  }
}

// Into the cells of `to` that are not in `from`.
void Tracy::EnterCells(uint32_t object, const CellRange& from, const CellRange& to) {
  if (!to.IsInCells()) return;
  CellPosition first{};
  CellPosition last{};
  if (from.IsInCells()) {
    first = PositionOf(layout_, from.first);
    last = PositionOf(layout_, from.last);
  }
  ForEachCell(to, [&](const CellPosition& position) {
    bool was_inside = from.IsInCells();
    for (int axis = 0; axis < 3; ++axis) {
      was_inside &= first.at[axis] <= position.at[axis] && position.at[axis] <= last.at[axis];
    }
    if (!was_inside) lists_.Append(NumberOf(layout_, position), object);
  });
}

void Tracy::FindPairs(PairBuffer& out) {
  checks_ = SweepCells(Input(), lists_, room_, out);
  tidy_ = true;
  if (large_count_ > 0) checks_ += FindPairsOfLarge(out);
  fewest_checks_ = std::min(fewest_checks_, checks_);
  excess_checks_ += checks_ - fewest_checks_;
}

uint64_t Tracy::FindPairsOfLarge(PairBuffer& out) {
  large_order_.EnsureDiscarding(count_);
  size_t front = 0;
  size_t back = count_ - large_count_;
  for (uint32_t i = 0; i < count_; ++i) {
    large_order_[ranges_[i].first == CellRange::kLarge ? back++ : front++] = i;
  }
  large_lanes_.Gather({boxes_.data(), count_}, {large_order_.data(), count_});
  return FindPairsOfLast(large_lanes_.Lanes(), front, back, out);
}

size_t Tracy::native_bytes() const {
  return boxes_.capacity_bytes() + ranges_.capacity_bytes() + lists_.native_bytes() +
         room_.native_bytes() + batch_.native_bytes() + batch_ranges_.capacity_bytes() +
         sizes_.capacity_bytes() + large_order_.capacity_bytes() + large_lanes_.native_bytes();
}

}  // namespace

std::unique_ptr<BroadPhase> MakeTracy(const BroadPhaseOptions& options) {
  return std::make_unique<Tracy>(options);
}

}  // namespace sweepstake
