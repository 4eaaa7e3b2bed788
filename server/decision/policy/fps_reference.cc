#include "server/decision/policy/fps_reference.h"

#include <algorithm>

namespace sweepstake::decision {

void FpsReference::Add(double fps) {
  fps_[next_] = fps;
  next_ = (next_ + 1) % kWindowCount;
  count_ = std::min(count_ + 1, kWindowCount);
}

double FpsReference::Quantile(double p) const {
  if (count_ == 0) return 0;
  std::array<double, kWindowCount> sorted = fps_;
  std::sort(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(count_));
  const double h = static_cast<double>(count_ - 1) * p;
  const size_t k = std::min(static_cast<size_t>(h), count_ - 1);
  const size_t above = std::min(k + 1, count_ - 1);
  return sorted[k] + (h - static_cast<double>(k)) * (sorted[above] - sorted[k]);
}

double FpsReference::Score(double fps) const {
  if (fps < kNearStallFps) return 0;
  const double high = std::max(Quantile(0.95), kLeastHigh);
  const double low = std::min(Quantile(0.05), high / 2);
  return std::clamp((fps - low) / (high - low), 0.0, 1.0);
}

}  // namespace sweepstake::decision
