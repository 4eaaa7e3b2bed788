#include "engine_client/broad_phase/kd/size_classes.h"

#include <algorithm>
#include <cmath>

namespace sweepstake {
namespace {

// Of a leaf's width: up to there a box costs its leaf less than being apart would.
constexpr double kLongInLeaves = 1.5;
// Of the lower quartile of the extents on its axis.
constexpr float kLongInQuartiles = 4;
constexpr double kLeaf = 16;
constexpr size_t kSample = 64;

// A quarter of the extents are below, as far as a sample can tell.
float LowerQuartile(const float* extents, size_t count) {
  std::array<float, kSample> sample;
  for (size_t k = 0; k < kSample; ++k) sample[k] = extents[k * count / kSample];
  std::nth_element(sample.begin(), sample.begin() + kSample / 4, sample.end());
  return sample[kSample / 4];
}

}  // namespace

SizeClasses::SizeClasses(const AxisSpread (&spreads)[3], const float* const (&extents)[3],
                         size_t count) {
  double room = kLeaf / static_cast<double>(count);
  for (const AxisSpread& axis : spreads) {
    room *= double{axis.greatest_center} - double{axis.least_center} +
            axis.extent_sum / static_cast<double>(count);
  }
  step_ = static_cast<float>(kLongInLeaves * std::cbrt(room));
  for (size_t axis = 0; axis < 3; ++axis) {
    long_from_[axis] = std::max(step_, kLongInQuartiles * LowerQuartile(extents[axis], count));
    if (spreads[axis].greatest_extent > long_from_[axis]) all_ordinary_ = false;
  }
}

size_t SizeClasses::ClassOf(float extent0, float extent1, float extent2) const {
  if (extent0 <= long_from_[0] && extent1 <= long_from_[1] && extent2 <= long_from_[2]) return 0;
  const float longest = std::max({extent0, extent1, extent2});
  // Beside an axis that is eight times as long the others are thin.
  const float thin = longest * 0.125F;
  const size_t axes = (extent0 > std::max(long_from_[0], thin) ? 1U : 0U) |
                      (extent1 > std::max(long_from_[1], thin) ? 2U : 0U) |
                      (extent2 > std::max(long_from_[2], thin) ? 4U : 0U);
  size_t level = 0;
  for (float limit = step_ * 4; level < 3 && longest > limit; limit *= 4) ++level;
  return level * 8 + axes;
}

std::array<size_t, SizeClasses::kCount> SizeClasses::ClassifyAll(
    const float* const (&extents)[3], std::span<uint32_t> classes) const {
  std::array<size_t, kCount> counts{};
  for (size_t i = 0; i < classes.size(); ++i) {
    const size_t of_box = ClassOf(extents[0][i], extents[1][i], extents[2][i]);
    classes[i] = static_cast<uint32_t>(of_box);
    ++counts[of_box];
  }
  return counts;
}

}  // namespace sweepstake
