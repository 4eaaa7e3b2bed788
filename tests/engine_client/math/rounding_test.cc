// The series and loops of math/ end in every rounding mode, also with flushed subnormal numbers.
// The library sets the default mode before it calls them (float_environment.h), but a hang would be
// worse than a wrong digit.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "engine_client/math/beta_distribution.h"
#include "engine_client/math/maximum.h"
#include "engine_client/math/normal_distribution.h"
#include "engine_client/math/random.h"
#include "tests/support/float_modes.h"

namespace sweepstake::decision {
namespace {

using test_support::FloatMode;

std::vector<FloatMode> ModesWithoutTraps() {
  std::vector<FloatMode> modes = test_support::FloatModes();
  std::erase_if(modes, [](const FloatMode& mode) { return mode.name.ends_with("traps"); });
  return modes;
}

class MathInEachRounding : public testing::TestWithParam<FloatMode> {
 protected:
  // Returns results in the mode of the parameter, or in the default one.
  template <typename Function>
  std::vector<double> InMode(const Function& function) {
    std::vector<double> results;
    EXPECT_TRUE(test_support::KeepsMode(GetParam(), [&] { results = function(); }));
    return results;
  }
  static void ExpectNear(const std::vector<double>& found, const std::vector<double>& expected) {
    ASSERT_EQ(found.size(), expected.size());
    for (size_t i = 0; i < found.size(); ++i) {
      EXPECT_NEAR(found[i], expected[i], 1e-9 * std::max(1.0, std::abs(expected[i]))) << i;
    }
  }
};

TEST_P(MathInEachRounding, NormalDistribution) {
  const auto values = [] {
    std::vector<double> found;
    for (const double z : {-40.0, -5.0, -2.9, -1.0, -1e-9, -5e-324, 0.0, 1e-300, 0.3, 2.99, 7.0}) {
      found.push_back(NormalCdf(z));
      found.push_back(ExpectedGain(z, 0.5));
    }
    return found;
  };
  ExpectNear(InMode(values), values());
}

TEST_P(MathInEachRounding, BetaDistribution) {
  const auto values = [] {
    std::vector<double> found;
    for (const BetaPosterior p : {BetaPosterior{1, 1}, {0.01, 5}, {40, 2}, {5000, 4000}}) {
      for (const double x : {1e-12, 0.1, 0.5, 0.97}) found.push_back(BetaDistribution(p, x));
      for (const double q : {1e-6, 0.05, 0.5, 0.95}) found.push_back(BetaQuantile(p, q));
    }
    return found;
  };
  ExpectNear(InMode(values), values());
}

TEST_P(MathInEachRounding, RandomDraws) {
  const auto values = [] {
    std::vector<double> found;
    for (const double shape :
         {0.0, 1e-310, 0.3, 1.0, 12.5, 1e12, std::numeric_limits<double>::infinity()}) {
      RandomStream stream(7, RandomPurpose::kChoice, 1, 0);
      found.push_back(std::isfinite(DrawLogGamma(shape, stream)) ? 1 : 0);
      found.push_back(DrawNormal(stream) > -20 ? 1 : 0);
    }
    return found;
  };
  ExpectNear(InMode(values), std::vector<double>(14, 1));
}

// Two normal variables, of which one may be so narrow that the integration steps reach the
// resolution of t.
class TwoNormals final : public IndependentVariables {
 public:
  explicit TwoNormals(double narrow) : deviations_{1, narrow} {}
  size_t count() const override { return 2; }
  double low(size_t variable) const override { return 1000 - 8 * deviations_[variable]; }
  double high(size_t variable) const override { return 1000 + 8 * deviations_[variable]; }
  double log_peak(size_t variable) const override {
    return -std::log(deviations_[variable] * 2.506628274631);
  }
  void MoveTo(double t) override { t_ = t; }
  ValueScale scale() const override { return {.value = t_}; }
  LogDensity At(size_t variable) const override {
    const double z = (t_ - 1000) / deviations_[variable];
    return {-z * z / 2, -z / deviations_[variable],
            -1 / (deviations_[variable] * deviations_[variable])};
  }

 private:
  std::vector<double> deviations_;
  double t_ = 0;
};

TEST_P(MathInEachRounding, MaximumOfVariables) {
  for (const double narrow : {1.0, 1e-6, 1e-13, 1e-16}) {
    const auto sum = [&] {
      TwoNormals variables(narrow);
      const Maximum maximum = IntegrateMaximum(variables);
      return std::vector<double>{maximum.probability[0] + maximum.probability[1]};
    };
    ExpectNear(InMode(sum), sum());
  }
}

// The density has no scale at all: the curvature is not a number.
class Undefined final : public IndependentVariables {
 public:
  size_t count() const override { return 2; }
  double low(size_t) const override { return 0; }
  double high(size_t) const override { return 1; }
  double log_peak(size_t) const override { return 0; }
  void MoveTo(double) override {}
  ValueScale scale() const override { return {}; }
  LogDensity At(size_t) const override { return {0, 0, std::numeric_limits<double>::quiet_NaN()}; }
};

TEST_P(MathInEachRounding, TheMaximumOfUndefinedVariablesEnds) {
  const auto count = [] {
    Undefined variables;
    return std::vector<double>{static_cast<double>(IntegrateMaximum(variables).probability.size())};
  };
  ExpectNear(InMode(count), {2});
}

INSTANTIATE_TEST_SUITE_P(, MathInEachRounding, testing::ValuesIn(ModesWithoutTraps()),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace sweepstake::decision
