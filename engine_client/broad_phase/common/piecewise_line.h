// A monotone function of a coordinate that rises where many sampled values lie: straight lines
// between some of the values, after which values and function rise about evenly.
//
// Plain values. Cost: Fit O(values · segments).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

namespace sweepstake {

// The function is the sum of its segments. Each is 0 before it begins, then rises linearly to
// `rise`, and is constant behind its end. Thus rounding cannot make the function fall. The sum of
// all `rise` is the number of values - 1.
template <size_t kMaxSegments>
struct PiecewiseLine {
  std::array<float, kMaxSegments> begin{};
  std::array<float, kMaxSegments> scale{};  // the rise per unit
  std::array<float, kMaxSegments> rise{};
  size_t count = 0;

  // Divides the worst segment until each misses no rank of a value by more than `max_missed`, or
  // until there are kMaxSegments (Ramer 1972, Douglas and Peucker 1973). REQUIRES: `values` are
  // sorted and not empty, and their differences are finite.
  static PiecewiseLine Fit(std::span<const float> values, float max_missed);
};

// The values `first` to `last`, which a straight line connects.
struct LinePiece {
  size_t first;
  size_t last;
  size_t worst = 0;  // the value whose rank the line misses by the most
  float missed = 0;  // by how many ranks the line misses it

  LinePiece() = default;
  LinePiece(std::span<const float> values, size_t from, size_t to)
      : first(from), last(to), worst(from) {
    if (values[first] == values[last]) return;
    const float scale = Scale(values);
    for (size_t k = first + 1; k < last; ++k) {
      const float rank = (values[k] - values[first]) * scale;
      const float miss = std::abs(rank - static_cast<float>(k - first));
      if (miss <= missed) continue;
      worst = k;
      missed = miss;
    }
  }
  // Returns the rise per unit. It is positive and finite, so that its product with an infinite
  // length is not NaN.
  float Scale(std::span<const float> values) const {
    constexpr float kMinScale = 1e-37F;
    constexpr float kMaxScale = 1e37F;
    const float length = values[last] - values[first];
    return length > 0 ? std::clamp(Rise() / length, kMinScale, kMaxScale) : kMaxScale;
  }
  float Rise() const { return static_cast<float>(last - first); }
};

template <size_t kMaxSegments>
PiecewiseLine<kMaxSegments> PiecewiseLine<kMaxSegments>::Fit(std::span<const float> values,
                                                             float max_missed) {
  std::array<LinePiece, kMaxSegments> pieces;
  size_t count = 0;
  pieces[count++] = LinePiece(values, 0, values.size() - 1);
  while (count < kMaxSegments) {
    LinePiece& worst = *std::max_element(
        pieces.begin(), pieces.begin() + count,
        [](const LinePiece& a, const LinePiece& b) { return a.missed < b.missed; });
    if (worst.missed <= max_missed) break;
    pieces[count++] = LinePiece(values, worst.worst, worst.last);
    worst = LinePiece(values, worst.first, worst.worst);
  }
  PiecewiseLine line;
  line.count = count;
  for (size_t k = 0; k < count; ++k) {
    line.begin[k] = values[pieces[k].first];
    line.scale[k] = pieces[k].Scale(values);
    line.rise[k] = pieces[k].Rise();
  }
  return line;
}

}  // namespace sweepstake
