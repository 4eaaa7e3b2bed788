// The maximum of several independent variables: the probability of each to be the maximum, and the
// expected maximum, by numeric integration over one adaptive grid that all variables share.
//
// Deterministic, thread-safe. Cost: some 40 grid points if the variables are of similar width, and
// one exponential per variable and point. Variables that are certainly below another one cost
// nothing. Error of each probability: 1e-6 (tests/engine_client/decider/policy/diagnosis_test.cc).
#pragma once

#include <cstddef>
#include <vector>

namespace sweepstake::decision {

// A density is negligible if its logarithm minus the logarithm of its peak is below this limit.
inline constexpr double kNegligibleLogDensity = -28;

// The logarithm of a density at a point, with its derivatives. The logarithm must be concave.
struct LogDensity {
  double relative = 0;  // difference from the peak, <= 0
  double slope = 0;
  double curvature = 0;  // < 0
};

// The value v of the variables as a function of the integration parameter t: v at a point, with its
// derivatives by t.
struct ValueScale {
  double value = 0;
  double rate = 1;  // dv/dt, > 0
  double log_rate_slope = 0;
  double log_rate_curvature = 0;
};

// Independent variables as functions of a common parameter t. The density of each has one peak.
class IndependentVariables {
 public:
  virtual ~IndependentVariables() = default;
  virtual size_t count() const = 0;
  // Outside of [low, high] the logarithm of the density, relative to its peak, is below
  // kNegligibleLogDensity. low < high.
  virtual double low(size_t variable) const = 0;
  virtual double high(size_t variable) const = 0;
  // The logarithm of the variable's highest density along t.
  virtual double log_peak(size_t variable) const = 0;
  // Sets the point at which scale() and At() are evaluated.
  virtual void MoveTo(double t) = 0;
  virtual ValueScale scale() const = 0;
  virtual LogDensity At(size_t variable) const = 0;
};

struct Maximum {
  std::vector<double> probability;  // one per variable; their sum is 1
  double expected_value = 0;        // expected value of the maximum
};

// Returns the distribution of the maximum. REQUIRES: variables.count() > 0.
Maximum IntegrateMaximum(IndependentVariables& variables);

}  // namespace sweepstake::decision
