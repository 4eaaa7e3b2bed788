// Computes scene descriptors from a small sample of objects. The cost per frame is small and does
// not depend on the size of the scene.
//
// Even frames store the boxes of kObjectsPerStep objects. Odd frames compare them with the new
// boxes of the same objects to measure motion. Every kPeriodFrames frames (a period) a descriptor
// is ready.
// - Its motion fields come from this period alone, so a change shows at once.
// - Its shape fields come from the latest kShapePeriods complete periods, in which kSampleCount
//   objects were sampled. Until then they come from the periods so far.
//
// In scenes of up to kSampleCount objects all objects are visited in turn. In larger scenes a
// low-discrepancy sequence chooses the objects, and reaches all of them eventually.
//
// Accuracy (standard error, independent objects):
// - size_spread ±5 %
// - speed_mean ±13 % × speed_spread ÷ speed_mean
// - static_ratio ±0.06
// - density_ratio ±6 % × relative spread of the volumes. Its bias is about +2 %, because the bounds
//   of the sample lie inside the bounds of the scene.
// - clustering_ratio ±0.18 · n ÷ sample. It is measured on the sample and scaled to the whole scene
//   by D = 1 + (D_sample − 1) · n ÷ sample, which is exact for independent thinning. It
//   distinguishes uniform from clustered scenes, but not two similar degrees of clustering.
//
// While a scene's object count changes, its descriptor has no motion fields, because an index may
// belong to another object after the change.
//
// Not thread-safe. Allocates nothing; the object has about 4 KB. Invalid boxes (aabb.h) are
// skipped. Units: world units and frames.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "sweepstake/aabb.h"
#include "sweepstake/frame_sample.h"

namespace sweepstake {

class DescriptorEstimator {
 public:
  static constexpr uint32_t kObjectsPerStep = 2;
  static constexpr uint32_t kSampleCount = 256;
  static constexpr uint32_t kShapePeriods = 4;
  static constexpr uint32_t kPeriodFrames = 2 * kSampleCount / kObjectsPerStep / kShapePeriods;

  void Observe(std::span<const Aabb> boxes);

  // Returns true when a period has ended, until Take is called.
  bool ready() const { return frame_count_ >= kPeriodFrames; }
  // Returns the descriptor of the period that has ended, and begins the next period. A field that
  // could not be measured is -1.
  SceneDescriptor Take();

 private:
  struct Point {
    float coordinate[3];
  };
  // Sums from which the mean and the standard deviation are computed.
  struct Moments {
    double sum = 0;
    double square_sum = 0;
    uint32_t count = 0;

    void Add(double value);
    double Mean() const;
    double Spread() const;
  };

  void StoreSample(std::span<const Aabb> boxes);
  void MeasureMotion(std::span<const Aabb> boxes);
  void AddShape(const Aabb& box);
  void DescribeShape();
  uint32_t NextIndex(uint32_t object_count);
  double DensityRatio(const Aabb& bounds) const;
  double ClusteringRatio(const Aabb& bounds) const;

  // State of the current step: an even frame and the odd frame after it.
  std::array<uint32_t, kObjectsPerStep> step_index_{};
  std::array<Aabb, kObjectsPerStep> step_box_{};
  uint32_t step_object_count_ = 0;  // object count of the even frame; 0 if nothing is stored
  uint64_t walk_ = 0;

  // The state of the current period.
  uint32_t frame_count_ = 0;
  uint32_t object_count_ = 0;
  Moments speed_;
  uint32_t static_count_ = 0;

  // The state of the shape fields.
  uint32_t period_count_ = 0;
  SceneDescriptor shape_;        // from the latest kShapePeriods complete periods
  bool shape_complete_ = false;  // kShapePeriods periods have ended
  std::array<Point, kSampleCount> centre_{};
  uint32_t centre_count_ = 0;
  Aabb bounds_{};
  Moments volume_;
  Moments log_size_;
};

}  // namespace sweepstake
