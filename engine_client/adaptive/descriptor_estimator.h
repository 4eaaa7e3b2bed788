// Scene descriptors from a small sample of objects, so that their cost per frame is small and does
// not depend on the size of the scene.
//
// Even frames store the boxes of kObjectsPerStep objects, odd frames compare them with the same
// objects' new boxes to measure their motion. After kPeriodFrames frames a descriptor is ready, of
// the period's motion, so that a change shows at once, and of the shape of the latest kShapePeriods
// periods, in which kSampleCount objects were sampled (of fewer until there were so many). Up to
// kSampleCount objects are visited in turn, more objects by a low-discrepancy walk over the
// indices, which reaches all of them in time.
//
// Accuracy (standard error, independent objects): size_spread ±5 %, speed_mean ±13 % × speed_spread
// ÷ speed_mean, static_ratio ±0.06, density_ratio biased up by some 2 % (the sample's bounds stay
// inside the scene's) plus ±6 % × the relative spread of the volumes. clustering_ratio is measured
// on the sample and scaled to the whole scene by D = 1 + (D_sample − 1) · n ÷ sample, exact for
// independent thinning, with a standard error of 0.18 · n ÷ sample: it tells uniform from
// clustered, not one clustering from a slightly different one. A scene with a changing object count
// has no motion fields while it changes: an index may then mean another object.
//
// Not thread-safe. Allocates nothing, holds about 4 KB. Invalid boxes (aabb.h) are skipped. Units:
// world units and frames.
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

  // Returns true once per kPeriodFrames frames, until Take is called.
  bool ready() const { return frame_count_ >= kPeriodFrames; }
  // Returns the descriptor of the period that has ended and begins the next one. A field that could
  // not be measured is -1.
  SceneDescriptor Take();

 private:
  struct Point {
    float coordinate[3];
  };
  // The sum and the sum of squares, which give a mean and a standard deviation.
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

  // The present step.
  std::array<uint32_t, kObjectsPerStep> step_index_{};
  std::array<Aabb, kObjectsPerStep> step_box_{};
  uint32_t step_object_count_ = 0;  // the objects of the frame; 0 if nothing is stored
  uint64_t walk_ = 0;

  // The present period.
  uint32_t frame_count_ = 0;
  uint32_t object_count_ = 0;
  Moments speed_;
  uint32_t static_count_ = 0;

  // The present periods of shape.
  uint32_t period_count_ = 0;
  SceneDescriptor shape_;        // of the latest kShapePeriods periods
  bool shape_complete_ = false;  // whether there were so many
  std::array<Point, kSampleCount> centre_{};
  uint32_t centre_count_ = 0;
  Aabb bounds_{};
  Moments volume_;
  Moments log_size_;
};

}  // namespace sweepstake
