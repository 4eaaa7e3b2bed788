#include "engine_client/cli/html/linear_axis.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace sweepstake::cli::html {

LinearAxis::LinearAxis(double low, double high) : low_(low), high_(high) {
  if (high_ > low_) return;
  const double half = std::max(std::abs(low) / 20, 0.05);
  low_ -= half;
  high_ += half;
}

double LinearAxis::Step(size_t most) const {
  const double least = (high_ - low_) / static_cast<double>(std::max<size_t>(most, 2));
  const double decade = std::pow(10, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * decade >= least * (1 - 1e-9)) return factor * decade;
  }
  return 10 * decade;
}

std::vector<double> LinearAxis::Ticks(size_t most) const {
  std::vector<double> ticks;
  const double step = Step(most);
  const double slack = 1e-9 * step;
  for (double index = std::ceil((low_ - slack) / step);
       index * step <= high_ + slack && ticks.size() < most; ++index) {
    ticks.push_back(index == 0 ? 0 : index * step);  // never −0
  }
  return ticks;
}

std::string LinearAxis::Text(double tick, size_t most) const {
  const int decimals = std::max(0, -static_cast<int>(std::floor(std::log10(Step(most)) + 1e-9)));
  std::array<char, 400> text{};
  std::snprintf(text.data(), text.size(), "%.*f", decimals, tick);
  return text.data();
}

}  // namespace sweepstake::cli::html
