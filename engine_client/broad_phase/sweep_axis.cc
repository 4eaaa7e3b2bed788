#include "engine_client/broad_phase/sweep_axis.h"

#include <cstddef>

namespace sweepstake {

int AxisOfLargestSpread(std::span<const Aabb> boxes) {
  constexpr size_t kSampleCount = 4096;
  const size_t stride = boxes.size() / kSampleCount + 1;
  double count = 0;
  double sum[3] = {};  // doubles: squares of the largest floats stay finite
  double square_sum[3] = {};
  for (size_t i = 0; i < boxes.size(); i += stride) {
    if (!TakesPart(boxes[i])) continue;
    ++count;
    for (int axis = 0; axis < 3; ++axis) {
      const double center = double{boxes[i].min[axis]} + double{boxes[i].max[axis]};
      sum[axis] += center;
      square_sum[axis] += center * center;
    }
  }
  int best = 0;
  double best_spread = -1;
  for (int axis = 0; axis < 3 && count > 0; ++axis) {
    const double spread = square_sum[axis] - sum[axis] * sum[axis] / count;
    if (spread > best_spread) {
      best_spread = spread;
      best = axis;
    }
  }
  return best;
}

}  // namespace sweepstake
