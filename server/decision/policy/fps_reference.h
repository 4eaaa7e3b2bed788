// The recent range of frame rates that a window's frame rate is judged against, with a floor for
// near stalls (the paper's adaptive FPS normalisation, §4, whose numbers are fixed here).
//
// The last 30 windows of the run, over all arms and kept across switches, the one being judged
// included. Fixed memory.
#pragma once

#include <array>
#include <cstddef>

namespace sweepstake::decision {

class FpsReference {
 public:
  static constexpr size_t kWindowCount = 30;
  static constexpr double kNearStallFps = 5;
  static constexpr double kLeastHigh = 30;

  // REQUIRES: fps is finite and >= 0. Drops the oldest window when full.
  void Add(double fps);

  // Quantile p in [0, 1] of the kept windows: with the values in ascending order x₀ … x₍ₘ₋₁₎ and h
  // = (m − 1)p, the value xₖ + (h − k)(xₖ₊₁ − xₖ), k = ⌊h⌋ (linear interpolation, Hyndman and Fan's
  // type 7). 0 where none is kept.
  double Quantile(double p) const;

  // hi = max(Q95, 30), lo = min(Q05, hi/2): clamp((fps − lo) / (hi − lo), 0, 1), and 0 below 5 FPS.
  double Score(double fps) const;

 private:
  std::array<double, kWindowCount> fps_{};
  size_t count_ = 0;
  size_t next_ = 0;
};

}  // namespace sweepstake::decision
