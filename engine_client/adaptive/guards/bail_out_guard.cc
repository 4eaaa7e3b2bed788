#include "engine_client/adaptive/guards/bail_out_guard.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "engine_client/broad_phase/host/float_environment.h"

namespace sweepstake {

BailOutGuard::BailOutGuard(uint64_t limit_ns, uint32_t arm_count)
    : limit_ns_(limit_ns), arm_count_(arm_count) {
  assert(limit_ns > 0 && arm_count >= 1 && arm_count <= kMaxArms);
}

void BailOutGuard::SetLimit(uint64_t limit_ns) {
  if (limit_ns > 0) limit_ns_.store(limit_ns, std::memory_order_relaxed);
}

void BailOutGuard::SetDeciderPresent(bool present) {
  decider_present_.store(present, std::memory_order_relaxed);
}

void BailOutGuard::SetPosteriorMeans(std::span<const double> means) {
  if (means.size() != arm_count_) return;
  if (!std::all_of(means.begin(), means.end(), [](double mean) { return std::isfinite(mean); })) {
    return;
  }
  for (size_t arm = 0; arm < means.size(); ++arm) {
    means_[arm].store(means[arm], std::memory_order_relaxed);
  }
  has_means_.store(true, std::memory_order_release);
}

bool BailOutGuard::IsCausedByArm(const FrameSample& sample) const {
  return Exceeds(sample.frame_time_ns) && IsCausedByDetection(sample);
}

std::optional<uint32_t> BailOutGuard::LocalChoice(const FrameSample& sample) const {
  if (!IsCausedByArm(sample) || arm_count_ < 2) return std::nullopt;
  if (decider_present_.load(std::memory_order_relaxed)) return std::nullopt;
  if (!has_means_.load(std::memory_order_acquire)) return (sample.arm + 1) % arm_count_;
  return BestOther(sample.arm);
}

uint32_t BailOutGuard::BestOther(uint32_t active) const {
  const FloatEnvironmentScope environment;
  uint32_t best = active == 0 ? 1 : 0;
  for (uint32_t arm = best + 1; arm < arm_count_; ++arm) {
    if (arm == active) continue;
    const double mean = means_[arm].load(std::memory_order_relaxed);
    if (mean > means_[best].load(std::memory_order_relaxed)) best = arm;
  }
  return best;
}

}  // namespace sweepstake
