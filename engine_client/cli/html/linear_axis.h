// A linear axis: where a value lies, and which values are worth a line. Value type; pure functions,
// safe from any thread.
#pragma once

#include <string>
#include <vector>

namespace sweepstake::cli::html {

class LinearAxis {
 public:
  // From `low` to `high`; a tenth wide at least where they are one. REQUIRES: finite, low <= high.
  LinearAxis(double low, double high);

  double low() const { return low_; }
  double high() const { return high_; }
  // 0 at low(), 1 at high().
  double Position(double value) const { return (value - low_) / (high_ - low_); }
  // Ascending, within the axis: multiples of 1, 2 or 5 times a power of ten, `most` at most.
  std::vector<double> Ticks(size_t most) const;
  // A tick's value, with as many digits as all of them need.
  std::string Text(double tick, size_t most) const;

 private:
  double Step(size_t most) const;

  double low_;
  double high_;
};

}  // namespace sweepstake::cli::html
