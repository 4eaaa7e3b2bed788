#include "engine_client/adaptive/descriptor_estimator.h"

#include <algorithm>
#include <cmath>

#include "engine_client/broad_phase/common/box_record.h"
#include "engine_client/math/hash.h"

namespace sweepstake {
namespace {

constexpr uint32_t kCellsPerAxis = 4;
// With fewer sampled points than this, clustering is not measured.
constexpr uint32_t kMinClusteringPoints = 16;

double Side(const Aabb& box, int axis) {
  return static_cast<double>(box.max[axis]) - static_cast<double>(box.min[axis]);
}

double Volume(const Aabb& box) { return Side(box, 0) * Side(box, 1) * Side(box, 2); }

double Centre(const Aabb& box, int axis) {
  return 0.5 * (static_cast<double>(box.min[axis]) + static_cast<double>(box.max[axis]));
}

double CentreDistance(const Aabb& a, const Aabb& b) {
  double square = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double step = Centre(b, axis) - Centre(a, axis);
    square += step * step;
  }
  return std::sqrt(square);
}

// Returns `value`, or -1 ("not measured") if it is negative or not finite.
float Measured(double value) {
  const float narrow = static_cast<float>(value);
  return std::isfinite(narrow) && narrow >= 0 ? narrow : -1.0F;
}

uint32_t CellOf(double coordinate, double low, double high, uint32_t cells) {
  const double cell = (coordinate - low) / (high - low) * cells;
  return std::min(static_cast<uint32_t>(std::max(cell, 0.0)), cells - 1);
}

// Returns variance ÷ mean of the counts.
double Dispersion(std::span<const uint32_t> counts, uint32_t total) {
  const double mean = static_cast<double>(total) / static_cast<double>(counts.size());
  double square_sum = 0;
  for (uint32_t count : counts) square_sum += (count - mean) * (count - mean);
  return square_sum / static_cast<double>(counts.size() - 1) / mean;
}

}  // namespace

void DescriptorEstimator::Moments::Add(double value) {
  sum += value;
  square_sum += value * value;
  ++count;
}

double DescriptorEstimator::Moments::Mean() const { return count == 0 ? -1 : sum / count; }

double DescriptorEstimator::Moments::Spread() const {
  if (count == 0) return -1;
  const double mean = sum / count;
  return std::sqrt(std::max(square_sum / count - mean * mean, 0.0));
}

void DescriptorEstimator::Observe(std::span<const Aabb> boxes) {
  object_count_ = static_cast<uint32_t>(boxes.size());
  if (frame_count_ % 2 == 0) {
    StoreSample(boxes);
  } else {
    MeasureMotion(boxes);
  }
  ++frame_count_;
}

void DescriptorEstimator::StoreSample(std::span<const Aabb> boxes) {
  step_object_count_ = object_count_;
  if (boxes.empty()) return;
  for (uint32_t i = 0; i < kObjectsPerStep; ++i) {
    step_index_[i] = NextIndex(object_count_);
    step_box_[i] = boxes[step_index_[i]];
    if (IsValidFast(step_box_[i])) AddShape(step_box_[i]);
  }
}

void DescriptorEstimator::MeasureMotion(std::span<const Aabb> boxes) {
  if (step_object_count_ != object_count_ || boxes.empty()) return;
  for (uint32_t i = 0; i < kObjectsPerStep; ++i) {
    const Aabb& before = step_box_[i];
    const Aabb& now = boxes[step_index_[i]];
    if (!IsValidFast(before) || !IsValidFast(now)) continue;
    speed_.Add(CentreDistance(before, now));
    static_count_ += before == now ? 1 : 0;
  }
}

void DescriptorEstimator::AddShape(const Aabb& box) {
  volume_.Add(Volume(box));
  const double longest = std::max({Side(box, 0), Side(box, 1), Side(box, 2)});
  if (longest > 0) log_size_.Add(std::log(static_cast<float>(longest)));
  if (centre_count_ == 0) bounds_ = box;
  for (int axis = 0; axis < 3; ++axis) {
    bounds_.min[axis] = std::min(bounds_.min[axis], box.min[axis]);
    bounds_.max[axis] = std::max(bounds_.max[axis], box.max[axis]);
  }
  if (centre_count_ == std::min(kSampleCount, object_count_)) return;
  Point& point = centre_[centre_count_++];
  for (int axis = 0; axis < 3; ++axis) {
    point.coordinate[axis] = static_cast<float>(Centre(box, axis));
  }
}

uint32_t DescriptorEstimator::NextIndex(uint32_t object_count) {
  const uint64_t step = walk_++;
  if (object_count <= kSampleCount) return static_cast<uint32_t>(step % object_count);
  // Multiples of the golden ratio modulo 1 are spread evenly over [0, 1), whatever their number.
  const uint64_t fraction = (step * math::kGoldenGamma) >> 32;
  return static_cast<uint32_t>((fraction * object_count) >> 32);
}

double DescriptorEstimator::DensityRatio(const Aabb& bounds) const {
  const double space = Volume(bounds);
  if (volume_.count == 0 || !(space > 0)) return -1;
  return volume_.Mean() * object_count_ / space;
}

double DescriptorEstimator::ClusteringRatio(const Aabb& bounds) const {
  if (centre_count_ < kMinClusteringPoints) return -1;
  std::array<uint32_t, kCellsPerAxis * kCellsPerAxis * kCellsPerAxis> counts{};
  uint32_t cells[3];
  for (int axis = 0; axis < 3; ++axis) cells[axis] = Side(bounds, axis) > 0 ? kCellsPerAxis : 1;
  const uint32_t cell_count = cells[0] * cells[1] * cells[2];
  if (cell_count < 2) return -1;
  for (uint32_t i = 0; i < centre_count_; ++i) {
    uint32_t cell = 0;
    for (int axis = 0; axis < 3; ++axis) {
      if (cells[axis] == 1) continue;
      cell = cell * cells[axis] +
             CellOf(centre_[i].coordinate[axis], bounds.min[axis], bounds.max[axis], cells[axis]);
    }
    ++counts[cell];
  }
  const double of_sample = Dispersion(std::span(counts).first(cell_count), centre_count_);
  const double scale = static_cast<double>(object_count_) / centre_count_;
  return std::max(1 + (of_sample - 1) * scale, 0.0);
}

SceneDescriptor DescriptorEstimator::Take() {
  if (++period_count_ == kShapePeriods || !shape_complete_) DescribeShape();
  SceneDescriptor descriptor = shape_;
  descriptor.object_count = static_cast<float>(object_count_);
  descriptor.speed_mean = Measured(speed_.Mean());
  descriptor.speed_spread = Measured(speed_.Spread());
  if (speed_.count > 0) {
    descriptor.static_ratio = Measured(static_cast<double>(static_count_) / speed_.count);
  }
  frame_count_ = step_object_count_ = static_count_ = 0;
  speed_ = Moments{};
  return descriptor;
}

void DescriptorEstimator::DescribeShape() {
  shape_.density_ratio = Measured(DensityRatio(bounds_));
  shape_.size_spread = Measured(log_size_.Spread());
  shape_.clustering_ratio = Measured(ClusteringRatio(bounds_));
  if (period_count_ < kShapePeriods) return;
  shape_complete_ = true;
  period_count_ = centre_count_ = 0;
  volume_ = log_size_ = Moments{};
}

}  // namespace sweepstake
