// The greatest of several independent variables: for each the probability of being it, and the
// expected value. By numeric integration over one adaptive grid that all of them share.
//
// Deterministic, thread-safe. Cost: some 40 points of the grid where the variables are of similar
// width, and an exponential for each variable and point. Variables that are certainly below another
// one cost nothing. Error of each probability: 1e-6 (tests/server/decision/diagnosis_test.cc).
#pragma once

#include <cstddef>
#include <vector>

namespace sweepstake::decision {

// How far below its peak the logarithm of a density may be before it stops to matter.
inline constexpr double kNegligibleLogDensity = -28;

// The logarithm of a density, a concave function, at a point.
struct LogDensity {
  double relative = 0;  // to its peak, <= 0
  double slope = 0;
  double curvature = 0;  // < 0
};

// How the value v of the variables runs along the axis t of the grid, at a point.
struct ValueScale {
  double value = 0;
  double rate = 1;  // dv/dt, > 0
  double log_rate_slope = 0;
  double log_rate_curvature = 0;
};

// Independent variables on a common axis t, each with one peak.
class IndependentVariables {
 public:
  virtual ~IndependentVariables() = default;
  virtual size_t count() const = 0;
  // Outside of these its density is below kNegligibleLogDensity. low < high.
  virtual double low(size_t variable) const = 0;
  virtual double high(size_t variable) const = 0;
  // Logarithm of its highest density along t.
  virtual double log_peak(size_t variable) const = 0;
  // Goes to the point that the functions below speak of.
  virtual void MoveTo(double t) = 0;
  virtual ValueScale scale() const = 0;
  virtual LogDensity At(size_t variable) const = 0;
};

struct Greatest {
  std::vector<double> probability;  // per variable, sum 1
  double expected_value = 0;        // of the greatest of them
};

// REQUIRES: there are variables.
Greatest FindGreatest(IndependentVariables& variables);

}  // namespace sweepstake::decision
