#include "engine_client/math/difference_variances.h"

#include <algorithm>
#include <cassert>
#include <cstddef>

#include "engine_client/math/portable_math.h"

namespace sweepstake::decision {
namespace {

constexpr double kMinVariance = 1e-18;
// The minimum weight, which keeps the equations solvable for variables that cannot be the lowest.
constexpr double kMinWeight = 1e-9;
// The number of Gauss–Seidel sweeps. Fewer already give the sums of pairs with large weights to
// within 1e-6.
constexpr int kSweepCount = 30;

class LeastSquares {
 public:
  LeastSquares(std::span<const double> means, std::span<const double> covariance);
  std::vector<double> Solve() const;

 private:
  struct Pair {
    double weight = 0;
    double variance = 0;
  };

  size_t count_;
  std::vector<Pair> pairs_;  // an n × n matrix, row by row
  std::vector<double> start_;
};

LeastSquares::LeastSquares(std::span<const double> means, std::span<const double> covariance)
    : count_(means.size()), pairs_(count_ * count_), start_(count_) {
  for (size_t i = 0; i < count_; ++i) {
    for (size_t j = 0; j < count_; ++j) {
      const double variance =
          covariance[i * count_ + i] + covariance[j * count_ + j] - 2 * covariance[i * count_ + j];
      pairs_[i * count_ + j].variance = std::max(variance, kMinVariance);
    }
  }
  const auto lowest =
      static_cast<size_t>(std::min_element(means.begin(), means.end()) - means.begin());
  std::vector<double> openness(count_);
  for (size_t i = 0; i < count_; ++i) {
    const double variance = pairs_[lowest * count_ + i].variance;
    const double distance = means[i] - means[lowest];
    openness[i] = kMinWeight + math::Exp(-0.5 * distance * distance / variance);
    start_[i] = variance / 2;
  }
  for (size_t i = 0; i < count_; ++i) {
    for (size_t j = 0; j < count_; ++j) {
      Pair& pair = pairs_[i * count_ + j];
      pair.weight = i == j ? 0 : openness[i] * openness[j] / (pair.variance * pair.variance);
    }
  }
}

// Solves by Gauss–Seidel sweeps, with the variables clamped at 0.
std::vector<double> LeastSquares::Solve() const {
  std::vector<double> variances = start_;
  for (int sweep = 0; sweep < kSweepCount; ++sweep) {
    for (size_t i = 0; i < count_; ++i) {
      double weights = 0;
      double sum = 0;
      for (size_t j = 0; j < count_; ++j) {
        const Pair& pair = pairs_[i * count_ + j];
        weights += pair.weight;
        sum += pair.weight * (pair.variance - variances[j]);
      }
      if (weights > 0) variances[i] = std::max(sum / weights, 0.0);
    }
  }
  return variances;
}

}  // namespace

std::vector<double> IndependentVariancesLike(std::span<const double> means,
                                             std::span<const double> covariance) {
  assert(covariance.size() == means.size() * means.size());
  if (means.empty()) return {};
  return LeastSquares(means, covariance).Solve();
}

}  // namespace sweepstake::decision
