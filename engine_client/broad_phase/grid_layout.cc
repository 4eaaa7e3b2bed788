#include "engine_client/broad_phase/grid_layout.h"

#include <algorithm>
#include <bit>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine_client/broad_phase/grid_layout.cc"
#include "hwy/foreach_target.h"  // IWYU pragma: keep
// After foreach_target.h.
#include "hwy/highway.h"

HWY_BEFORE_NAMESPACE();
namespace sweepstake::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void MeasureCorners(const BoxLanes& lanes, BoxSpread& spread) {
  const HWY_FULL(float) d;
  const auto limit = hn::Set(d, std::numeric_limits<float>::max());
  size_t count = 0;
  for (size_t axis = 0; axis < 3; ++axis) {
    auto low = limit;
    auto high = hn::Neg(limit);
    count = 0;
    for (size_t at = 0; at < lanes.count; at += hn::Lanes(d)) {
      const auto corner = hn::LoadU(d, lanes.min[axis] + at);
      const auto present = hn::Le(corner, limit);
      low = hn::Min(low, corner);
      high = hn::Max(high, hn::IfThenElse(present, corner, high));
      count += hn::CountTrue(d, present);
    }
    spread.low[axis] = hn::GetLane(hn::MinOfLanes(d, low));
    spread.high[axis] = hn::GetLane(hn::MaxOfLanes(d, high));
  }
  spread.count = count;
}

void MeasureSides(const BoxLanes& lanes, BoxSpread& spread) {
  const HWY_FULL(float) d;
  const hn::RebindToUnsigned<decltype(d)> du;
  HWY_ALIGN uint32_t classes[HWY_MAX_BYTES / sizeof(uint32_t)];
  const auto limit = hn::Set(d, std::numeric_limits<float>::max());
  auto longest = hn::Zero(d);
  const size_t step = hn::Lanes(d);
  for (size_t at = 0; at < lanes.count; at += step) {
    auto side = hn::Zero(d);
    for (size_t axis = 0; axis < 3; ++axis) {
      const auto extent =
          hn::Sub(hn::LoadU(d, lanes.max[axis] + at), hn::LoadU(d, lanes.min[axis] + at));
      side = hn::Max(side, extent);
    }
    side = hn::Min(side, limit);
    longest = hn::Max(longest, side);
    hn::Store(hn::ShiftRight<BoxSpread::kSideClassShift>(hn::BitCast(du, side)), du, classes);
    for (size_t lane = 0; lane < step; ++lane) ++spread.side_counts[classes[lane]];
  }
  const size_t read = (lanes.count + step - 1) / step * step;
  spread.side_counts[0] -= static_cast<uint32_t>(read - spread.count);  // sentinels
  spread.longest_side = hn::GetLane(hn::MaxOfLanes(d, longest));
}

void MeasureAll(const BoxLanes& lanes, BoxSpread& spread) {
  MeasureCorners(lanes, spread);
  MeasureSides(lanes, spread);
}

}  // namespace sweepstake::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE

namespace sweepstake {
namespace {

HWY_EXPORT(MeasureAll);

// A scan reads at least a register of each of five rows.
constexpr double kLeastLanesPerBox = 80;
// Half of the 27 cells around a box.
constexpr double kCellsPerBox = 13.5;
// Enough for the outer tenths of a distribution.
constexpr size_t kCornerSample = 128;
// Rounding a side to cells must not make the box longer than one of them.
constexpr double kCellSlack = 1.0001;
// Keeps the scale finite.
constexpr double kLeastCell = 1e-36;
// Border included: the cells on one axis stay below 2^24, which a float holds exactly.
constexpr size_t kMostCells = size_t{1} << 27;

struct Bounds {
  double low[3];
  double high[3];
  double Extent(int axis) const { return high[axis] - low[axis]; }
};

Bounds AllCorners(const BoxSpread& spread) {
  Bounds bounds{};
  for (int axis = 0; axis < 3; ++axis) {
    bounds.low[axis] = spread.low[axis];
    bounds.high[axis] = spread.high[axis];
  }
  return bounds;
}

// Without the outer tenths of a sample, widened by half their extent, within all corners.
Bounds MostCorners(const BoxLanes& lanes, const BoxSpread& spread) {
  Bounds bounds = AllCorners(spread);
  const size_t stride = lanes.count / kCornerSample + 1;
  std::array<float, kCornerSample + 1> sample;
  for (int axis = 0; axis < 3; ++axis) {
    size_t taken = 0;
    for (size_t i = 0; i < lanes.count; i += stride) {
      const float corner = lanes.min[axis][i];
      if (corner <= std::numeric_limits<float>::max()) sample[taken++] = corner;
    }
    if (taken == 0) continue;
    std::sort(sample.begin(), sample.begin() + static_cast<std::ptrdiff_t>(taken));
    const double low = sample[taken / 10];
    const double high = sample[taken - 1 - taken / 10];
    const double margin = (high - low) / 2;
    bounds.low[axis] = std::max(bounds.low[axis], low - margin);
    bounds.high[axis] = std::min(bounds.high[axis], high + margin);
  }
  return bounds;
}

// Cells per axis while they are being chosen; in double, since the first wish may be beyond any
// integer.
struct Division {
  double cell[3];
  double count[3];

  double Bordered() const { return (count[0] + 2) * (count[1] + 2) * (count[2] + 2); }
  void Divide(const Bounds& bounds, int axis) {
    count[axis] = static_cast<double>(1) + std::max(0.0, bounds.Extent(axis) / cell[axis]);
  }
};

Division DivideInto(const Bounds& bounds, double cell) {
  Division division{};
  for (int axis = 0; axis < 3; ++axis) {
    division.cell[axis] = cell;
    division.Divide(bounds, axis);
  }
  return division;
}

void Coarsen(const Bounds& bounds, double max_cells, Division& division) {
  while (division.Bordered() > max_cells) {
    const int axis =
        static_cast<int>(std::max_element(division.count, division.count + 3) - division.count);
    division.cell[axis] *= 2;
    division.Divide(bounds, axis);
  }
}

float UpperEdge(uint32_t side_class) {
  return std::bit_cast<float>((side_class + 1) << BoxSpread::kSideClassShift);
}

// Share of the space of the min corners that a cube of this side takes.
double CellShare(const BoxSpread& spread, double side) {
  double share = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const double extent = static_cast<double>(spread.high[axis]) - spread.low[axis];
    if (side < extent) share *= side / extent;
  }
  return share;
}

}  // namespace

uint32_t GridLayout::CellOf(float coordinate, int axis) const {
  const float cell = (coordinate * 0.5F - origin[axis]) * scale[axis];
  return static_cast<uint32_t>(std::clamp(cell, 0.0F, static_cast<float>(cells[axis] - 1)));
}

void MeasureSpread(const BoxLanes& lanes, BoxSpread& spread) {
  spread = BoxSpread();
  HWY_DYNAMIC_DISPATCH(MeasureAll)(lanes, spread);
}

float ChooseOrdinarySide(const BoxSpread& spread) {
  const double all = static_cast<double>(spread.count);
  double least = std::numeric_limits<double>::infinity();
  float best = 0;
  double ordinary = 0;
  for (uint32_t k = 0; k < BoxSpread::kSideClasses; ++k) {
    if (spread.side_counts[k] == 0) continue;
    ordinary += spread.side_counts[k];
    const float side = std::min(UpperEdge(k), spread.longest_side);
    const double met = kCellsPerBox * ordinary * CellShare(spread, side);
    const double large = all - ordinary;
    const double cost = ordinary * std::max(kLeastLanesPerBox, met) + large * all;
    if (cost > least) continue;
    least = cost;
    best = side;
  }
  return best;
}

GridLayout LayOutGrid(const BoxLanes& lanes, const BoxSpread& spread, float side,
                      size_t max_cells) {
  GridLayout layout;
  if (spread.count == 0) return layout;
  const double limit = static_cast<double>(std::min(std::max<size_t>(max_cells, 512), kMostCells));
  const double cell = std::max(kCellSlack * side, kLeastCell);
  Bounds bounds = AllCorners(spread);
  Division division = DivideInto(bounds, cell);
  if (division.Bordered() > limit) {
    bounds = MostCorners(lanes, spread);
    division = DivideInto(bounds, cell);
    Coarsen(bounds, limit, division);
  }
  for (int axis = 0; axis < 3; ++axis) {
    layout.origin[axis] = static_cast<float>(bounds.low[axis] * 0.5);
    layout.scale[axis] = static_cast<float>(2 / division.cell[axis]);
    layout.cells[axis] = static_cast<uint32_t>(division.count[axis]);
  }
  return layout;
}

}  // namespace sweepstake

#endif  // HWY_ONCE
