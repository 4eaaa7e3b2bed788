#include "engine_client/broad_phase/grid/grid_plan.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine_client/broad_phase/common/parallel.h"
#include "engine_client/broad_phase/common/soa_boxes.h"
#include "engine_client/broad_phase/grid/grid_cost.h"
#include "engine_client/broad_phase/grid/grid_sample.h"

namespace sweepstake {
namespace {

constexpr size_t kMinMeasuredPerPart = 4096;
constexpr size_t kMinStretchedPerPart = 1024;
// The axes are stretched if a box shares its cell with kCrowdedCell others or more, and if
// stretching saves kTestsPerStretch tests per box or more. These take as long as stretching a box.
constexpr size_t kMinCrowd = 256;
constexpr double kCrowdedCell = 32;
constexpr double kTestsPerStretch = 32;
// The estimates are rough. A choice that divides all axes is therefore kept unless the estimate of
// another choice, multiplied by this factor, is still lower.
constexpr double kDoubt = 3;
// The next checks of the density do not decide on stretched axes again, which takes as long as
// several frames of 1,000 boxes.
constexpr uint32_t kSkippedChecks = 7;
// The lengths of the axes that are tried until no cell is crowded. A short axis has one cell, so
// that the others have more.
constexpr float kShort = 1.0F / 1024;
constexpr std::array<std::array<float, 3>, 7> kAxisWeights = {{{1, 1, 1},
                                                               {1, 1, kShort},
                                                               {1, kShort, 1},
                                                               {kShort, 1, 1},
                                                               {1, kShort, kShort},
                                                               {kShort, 1, kShort},
                                                               {kShort, kShort, 1}}};
// The interval in frames at which the plan checks whether the scene's density has changed.
constexpr uint32_t kFramesPerDensityCheck = 32;
// The size of the sample of min corners, enough to estimate the lowest and the highest tenth.
constexpr size_t kCornerSample = 64;
// The value of ShapeClasses::threshold, as a multiple of the mean distance between boxes.
constexpr double kThresholdSpacings = 0.75;

GridMeasure MeasureInParts(Executor* executor, std::span<const Aabb> boxes,
                           const ShapeClasses& classes, StopRequest* stop) {
  const size_t parts = TablePartCount(executor, boxes.size(), kMinMeasuredPerPart);
  if (parts == 1) return MeasureBoxes(boxes, classes, stop);
  std::array<GridMeasure, kMaxTableParts> measures;
  RunParts(executor, parts, [&](size_t part) {
    const PartRange range = RangeOfPart(boxes.size(), part, parts, 64);
    measures[part] =
        MeasureBoxes(boxes.subspan(range.begin, range.end - range.begin), classes, stop);
  });
  for (size_t part = 1; part < parts; ++part) measures[0].Join(measures[part]);
  return measures[0];
}

CornerBounds CornersOf(const GridMeasure& measure) {
  CornerBounds bounds{};
  for (int axis = 0; axis < 3; ++axis) {
    bounds.low[axis] = measure.low[axis];
    bounds.high[axis] = measure.high[axis];
  }
  return bounds;
}

// Returns bounds that hold most min corners. These are the bounds of a sample without its lowest
// and highest tenth, widened by half their extent on each side and limited to `all`.
CornerBounds TypicalCorners(std::span<const Aabb> boxes, const CornerBounds& all) {
  CornerBounds bounds = all;
  const size_t stride = boxes.size() / kCornerSample + 1;
  for (int axis = 0; axis < 3; ++axis) {
    std::array<float, kCornerSample> sample;
    size_t taken = 0;
    for (size_t i = 0; i < boxes.size(); i += stride) {
      if (IsValid(boxes[i])) sample[taken++] = boxes[i].min[axis] * 0.5F;
    }
    if (taken == 0) continue;
    const size_t tenth = taken / 10;
    std::nth_element(sample.begin(), sample.begin() + tenth, sample.begin() + taken);
    const double low = sample[tenth];
    std::nth_element(sample.begin(), sample.begin() + (taken - 1 - tenth), sample.begin() + taken);
    const double high = sample[taken - 1 - tenth];
    const double margin = (high - low) / 2;
    bounds.low[axis] = std::max(bounds.low[axis], low - margin);
    bounds.high[axis] = std::min(bounds.high[axis], high + margin);
  }
  return bounds;
}

// Returns a value of ShapeClasses::threshold with which a cell holds a few boxes.
float SuitableThreshold(const CornerBounds& bounds, const GridMeasure& measure) {
  double volume = 1;
  float max_side[3] = {};
  for (const GroupShape& shape : measure.shapes) {
    for (int axis = 0; axis < 3; ++axis)
      max_side[axis] = std::max(max_side[axis], shape.max_side[axis]);
  }
  for (int axis = 0; axis < 3; ++axis) {
    volume *= std::max(bounds.high[axis] - bounds.low[axis], static_cast<double>(max_side[axis]));
  }
  const double spacing = 2 * std::cbrt(volume / std::max(1U, measure.count()));
  return static_cast<float>(std::clamp(kThresholdSpacings * spacing, 1e-30, 1e37));
}

uint64_t Populated(const GridMeasure& measure) {
  uint64_t classes = 0;
  for (uint32_t k = 0; k < ShapeClasses::kCount; ++k) {
    classes |= uint64_t{measure.shapes[k].count > 0} << k;
  }
  return classes;
}

}  // namespace

void GridPlan::Reset() {
  known_classes_ = 0;
  frame_ = 0;
  group_count_ = 0;
  is_stretched_ = false;
  skipped_checks_ = 0;
  choice_.classes.threshold = std::numeric_limits<float>::max();
}

GridBoxes GridPlan::MakeGrids(Executor* executor, std::span<const Aabb> boxes, StopRequest* stop) {
  const bool is_check_due = frame_ % kFramesPerDensityCheck == 0;
  const bool may_stretch = is_check_due && skipped_checks_ == 0;
  if (may_stretch) is_stretched_ = false;
  const GridBoxes both = InGrids(executor, boxes, stop);
  if (!MakeGridsOf(executor, both.in_grids, is_check_due, stop)) return both;
  ++frame_;
  if (may_stretch) return StretchIfCrowded(executor, boxes, stop);
  if (is_check_due) --skipped_checks_;
  return both;
}

// Makes the grids, after a check of the density if one is due. Returns whether a box is valid.
bool GridPlan::MakeGridsOf(Executor* executor, std::span<const Aabb> boxes, bool is_check_due,
                           StopRequest* stop) {
  GridMeasure measure = MeasureInParts(executor, boxes, choice_.classes, stop);
  if (is_check_due && UpdateThreshold(boxes, measure)) {
    measure = MeasureInParts(executor, boxes, choice_.classes, stop);
  }
  if (!Fits(measure)) Plan(measure);
  LayOut(boxes, measure);
  return measure.count() > 0;
}

// Stretches the axes if many boxes share a cell and if that saves enough tests.
GridBoxes GridPlan::StretchIfCrowded(Executor* executor, std::span<const Aabb> boxes,
                                     StopRequest* stop) {
  if (boxes.size() < kMinCrowd) return {boxes, boxes};
  const SampledGrids present{grids(), choice_, searches()};
  const BoxSample few(boxes, kEstimateCount);
  if (BoxesPerCell(few, present) < kCrowdedCell) return {boxes, boxes};
  skipped_checks_ = kSkippedChecks;
  const BoxSample sample(boxes, BoxSample::kMaxCount);
  double least = SearchTests(sample, present) - kTestsPerStretch;
  stretch_.Fit(boxes);
  AxisStretch best;
  for (const auto& weights : kAxisWeights) {
    AxisStretch stretch = stretch_;
    stretch.SetWeights(weights);
    BoxSample stretched = sample;
    stretch.Apply(sample.span(), stretched.boxes.data());
    MakeGridsOfSample(stretched);
    const SampledGrids in_stretched{grids(), choice_, searches()};
    const double doubt = &weights == kAxisWeights.data() ? 1 : kDoubt;
    const double tests = doubt * SearchTests(stretched, in_stretched);
    if (tests < least) {
      least = tests;
      best = stretch;
      is_stretched_ = true;
    }
    if (BoxesPerCell(stretched, in_stretched) < kCrowdedCell) break;
  }
  stretch_ = best;
  const GridBoxes both = InGrids(executor, boxes, stop);
  MakeGridsOf(executor, both.in_grids, true, stop);
  return both;
}

// Makes the grids that MakeGridsOf would make for all boxes, as far as a sample can show.
void GridPlan::MakeGridsOfSample(const BoxSample& sample) {
  const auto scaled = [&](GridMeasure measure) {
    for (GroupShape& shape : measure.shapes) {
      shape.count = static_cast<uint32_t>(shape.count * sample.all_count / sample.count);
    }
    return measure;
  };
  const GridMeasure measure = scaled(MeasureBoxes(sample.span(), choice_.classes));
  UpdateThreshold(sample.span(), measure);
  known_classes_ = 0;
  const GridMeasure again = scaled(MeasureBoxes(sample.span(), choice_.classes));
  Plan(again);
  LayOut(sample.span(), again);
}

GridBoxes GridPlan::InGrids(Executor* executor, std::span<const Aabb> boxes, StopRequest* stop) {
  if (!is_stretched_) return {boxes, boxes};
  stretched_.EnsureDiscarding(boxes.size());
  const size_t parts = PartCount(executor, boxes.size(), kMinStretchedPerPart);
  RunParts(executor, parts, [&](size_t part) {
    const PartRange range = RangeOfPart(boxes.size(), part, parts, SoaBoxes::kPadding);
    ForEachBlock(stop, range.begin, range.end, [&](size_t from, size_t to) {
      stretch_.Apply(boxes.subspan(from, to - from), stretched_.data() + from);
    });
  });
  return {boxes, {stretched_.data(), boxes.size()}};
}

// Changes the threshold of the shape classes if the density of boxes has changed. Returns whether
// the threshold changed.
bool GridPlan::UpdateThreshold(std::span<const Aabb> boxes, const GridMeasure& measure) {
  if (measure.count() == 0) return false;
  const float wanted = SuitableThreshold(TypicalCorners(boxes, CornersOf(measure)), measure);
  float& present = choice_.classes.threshold;
  if (wanted >= present / 2 && wanted <= 2 * present) return false;
  present = wanted;
  known_classes_ = 0;
  return true;
}

bool GridPlan::Fits(const GridMeasure& measure) const {
  return group_count_ > 0 && (Populated(measure) & ~known_classes_) == 0;
}

void GridPlan::Plan(const GridMeasure& measure) {
  known_classes_ |= Populated(measure);
  if (known_classes_ == 0) known_classes_ = 1;
  group_count_ =
      ChooseGroups(CornersOf(measure), measure, known_classes_, choice_.group_of_class, searches_);
}

void GridPlan::LayOut(std::span<const Aabb> boxes, const GridMeasure& measure) {
  std::array<GroupShape, kMaxGroups> shapes{};
  for (uint32_t k = 0; k < ShapeClasses::kCount; ++k) {
    shapes[choice_.group_of_class[k]].Add(measure.shapes[k]);
  }
  CornerBounds bounds = CornersOf(measure);
  bool has_all_corners = true;
  uint32_t first_cell = 0;
  for (size_t g = 0; g < group_count_; ++g) {
    const size_t max_cells = MaxCellCount(shapes[g].count);
    if (has_all_corners && CellsWanted(bounds, shapes[g]) > static_cast<double>(max_cells)) {
      bounds = TypicalCorners(boxes, bounds);
      has_all_corners = false;
    }
    grids_[g] = MakeGroupGrid(bounds, shapes[g], max_cells);
    grids_[g].first_cell = first_cell;
    first_cell = grids_[g].last_cell();
  }
}

}  // namespace sweepstake
