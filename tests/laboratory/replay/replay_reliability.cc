#include "tests/laboratory/replay/replay_reliability.h"

#include <algorithm>
#include <cmath>

#include "engine_client/decider/policy/diagnosis.h"

namespace sweepstake::cli {

void Reliability::Add(double probability, double loss_ratio) {
  const auto above = std::upper_bound(kEdges.begin() + 1, kEdges.end() - 1, probability);
  ReliabilityBin& bin = bins_[static_cast<size_t>(above - kEdges.begin()) - 1];
  ++bin.decision_count;
  bin.probability_sum += probability;
  if (loss_ratio <= 0) ++bin.best_count;
  if (loss_ratio <= decision::kTieLossRatio) ++bin.tie_count;
}

Reliability& Reliability::operator+=(const Reliability& other) {
  for (size_t i = 0; i < kBinCount; ++i) {
    bins_[i].decision_count += other.bins_[i].decision_count;
    bins_[i].probability_sum += other.bins_[i].probability_sum;
    bins_[i].best_count += other.bins_[i].best_count;
    bins_[i].tie_count += other.bins_[i].tie_count;
  }
  return *this;
}

uint64_t Reliability::decision_count() const {
  uint64_t count = 0;
  for (const ReliabilityBin& bin : bins_) count += bin.decision_count;
  return count;
}

double Reliability::error() const {
  double sum = 0;
  for (const ReliabilityBin& bin : bins_)
    sum += std::abs(bin.probability_sum - static_cast<double>(bin.best_count));
  return sum / static_cast<double>(std::max<uint64_t>(decision_count(), 1));
}

double ArmTimes::LossRatioOf(size_t arm) const {
  const double fastest_ns = *std::min_element(ns_.begin(), ns_.end());
  return fastest_ns > 0 ? ns_[arm] / fastest_ns - 1 : ns_[arm];
}

}  // namespace sweepstake::cli
