#include "engine_client/cli/html/log_axis.h"

#include <algorithm>
#include <cmath>

namespace sweepstake::cli::html {
namespace {

constexpr double kLeastFactor = 4;

// From this many decades only decades are labelled, and from the second every other one and so on.
constexpr double kManyDecades = 3.5;
constexpr double kTooManyDecades = 9;

bool IsLabelled(int digit, int decade, double decades) {
  if (decades > kTooManyDecades) {
    return digit == 1 && decade % static_cast<int>(std::ceil(decades / kTooManyDecades)) == 0;
  }
  if (decades > kManyDecades) return digit == 1;
  if (decades > 1) return digit == 1 || digit == 2 || digit == 5;
  return digit <= 5 || digit == 7;
}

}  // namespace

bool IsOnLogAxis(double value) { return value >= 1e-200 && value <= 1e200; }

LogAxis::LogAxis(std::span<const double> values, double margin_ratio) : low_(0), high_(0) {
  for (const double value : values) {
    if (!IsOnLogAxis(value)) continue;
    low_ = high_ == 0 ? value : std::min(low_, value);
    high_ = std::max(high_, value);
  }
  if (high_ == 0) {
    low_ = 1;
    high_ = 10;
    return;
  }
  low_ /= margin_ratio;
  high_ *= margin_ratio;
  const double missing = kLeastFactor * low_ / high_;
  if (missing > 1) {
    low_ /= std::sqrt(missing);
    high_ *= std::sqrt(missing);
  }
}

double LogAxis::Position(double value) const {
  return std::log(value / low_) / std::log(high_ / low_);
}

std::vector<Tick> LogAxis::Ticks() const {
  std::vector<Tick> ticks;
  const double decades = std::log10(high_ / low_);
  const int first = static_cast<int>(std::floor(std::log10(low_)));
  const int last = static_cast<int>(std::floor(std::log10(high_)));
  for (int decade = first; decade <= last; ++decade) {
    for (int digit = 1; digit <= 9; ++digit) {
      const double value = digit * std::pow(10.0, decade);
      if (value < low_ || value > high_) continue;
      if (decades > kTooManyDecades && digit > 1) continue;
      ticks.push_back({value, IsLabelled(digit, decade, decades)});
    }
  }
  return ticks;
}

std::vector<double> SpacedOut(const LogAxis& axis, std::span<const double> values, double gap) {
  if (values.empty()) return {};
  std::vector<double> kept{values.front()};
  const double last = axis.Position(values.back());
  for (const double value : values.subspan(1)) {
    const double position = axis.Position(value);
    const bool clear_of_last = value == values.back() || last - position >= gap;
    if (clear_of_last && position - axis.Position(kept.back()) >= gap) kept.push_back(value);
  }
  return kept;
}

}  // namespace sweepstake::cli::html
