// A logarithmic axis: where a value lies, and which values are worth a line. Value type; pure
// functions, safe from any thread.
#pragma once

#include <span>
#include <vector>

namespace sweepstake::cli::html {

struct Tick {
  double value = 0;
  bool labelled = false;  // else a fainter line without a number
};

class LogAxis {
 public:
  // Holds every value, with room for `margin_ratio` beyond the outermost; at least a factor of 4
  // wide. Values that have no logarithm (0, negative, not finite) are passed over; with none left
  // it is 1 to 10.
  LogAxis(std::span<const double> values, double margin_ratio);

  double low() const { return low_; }
  double high() const { return high_; }
  // 0 at low(), 1 at high(). REQUIRES: IsOnLogAxis(value).
  double Position(double value) const;
  // Ascending, all within [low, high]: decades, with 2 and 5 between them where there is room for
  // numbers at them, and the rest without. At least two are labelled.
  std::vector<Tick> Ticks() const;

 private:
  double low_;
  double high_;
};

// Whether a logarithmic axis has a place for `value`: within 1e-200 to 1e200.
bool IsOnLogAxis(double value);

// Of the ascending `values`, those whose label has room: `gap` of the axis' length apart at least;
// the outermost two come first.
std::vector<double> SpacedOut(const LogAxis& axis, std::span<const double> values, double gap);

}  // namespace sweepstake::cli::html
