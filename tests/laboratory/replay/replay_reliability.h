// Compares the probabilities that a policy states with the frequency at which it is right: a
// reliability table (A. Murphy, "Reliability of subjective probability forecasts", Applied
// Statistics 26, 1977).
//
// A decision states the arm with the highest P(best), the leader, and that probability. It is
// judged by the frames since the previous decision, for which the trace contains the time of every
// arm. Plain values.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sweepstake::cli {

// The decisions whose probability was in one range.
struct ReliabilityBin {
  uint64_t decision_count = 0;
  double probability_sum = 0;
  uint64_t best_count = 0;  // the leader was the fastest arm
  uint64_t tie_count = 0;   // or took at most kTieLossRatio (decision/policy/diagnosis.h) more time
  bool operator==(const ReliabilityBin&) const = default;
};

class Reliability {
 public:
  // A bin begins at its edge and ends before the next one; the last one includes its end, 1.
  static constexpr std::array kEdges = {0.0, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99, 1.0};
  static constexpr size_t kBinCount = kEdges.size() - 1;

  // Adds a decision. `loss_ratio` is the leader's time ÷ the fastest arm's, minus 1. REQUIRES: the
  // probability is 0–1.
  void Add(double probability, double loss_ratio);
  Reliability& operator+=(const Reliability& other);

  const std::array<ReliabilityBin, kBinCount>& bins() const { return bins_; }
  uint64_t decision_count() const;
  // Returns the calibration error: the mean over the decisions of |mean probability of the
  // decision's bin − share of that bin in which the leader was the fastest arm|. 0 without
  // decisions.
  double error() const;
  bool operator==(const Reliability&) const = default;

 private:
  std::array<ReliabilityBin, kBinCount> bins_{};
};

// Sums the times of the arms from one decision to the next.
class ArmTimes {
 public:
  explicit ArmTimes(size_t arm_count) : ns_(arm_count) {}

  void Add(size_t arm, double ns) { ns_[arm] += ns; }
  // Returns the arm's time ÷ the fastest arm's, minus 1. If the fastest arm's time is 0, returns
  // the arm's time.
  double LossRatioOf(size_t arm) const;
  // Returns whether no arm took any time.
  bool empty() const {
    return std::all_of(ns_.begin(), ns_.end(), [](double ns) { return ns == 0; });
  }
  void Clear() { ns_.assign(ns_.size(), 0); }

 private:
  std::vector<double> ns_;
};

}  // namespace sweepstake::cli
