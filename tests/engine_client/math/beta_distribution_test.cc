#include "engine_client/math/beta_distribution.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

namespace sweepstake::decision {
namespace {

// Reference values, computed with 40 digits: the incomplete beta function, or the integral of the
// density.
struct Reference {
  BetaPosterior posterior;
  double x;
  double distribution;
  double log_density;
};

const std::vector<Reference> kReferences = {
    {{2, 3}, 0.4, 0.52480000000000004, 0.54696467038186386},
    {{0.5, 0.5}, 0.1, 0.20483276469913346, 0.059242918476535794},
    {{1e-06, 1e-06}, 0.25, 0.49999945069467084, -12.834682978927337},
    {{0.001, 20}, 1e-05, 0.99206547381948256, 4.5970142027986137},
    {{31.5, 1.8}, 0.97, 0.68768736931520846, 2.5693574406469547},
    {{1000, 2500}, 0.29, 0.71392490124365949, 3.7904064756273321},
    {{2999, 3001}, 0.51, 0.94238404120079548, 2.8837456472810894},
    {{10000.0, 20000.0}, 0.32925091846837545, 0.066587038702408467, 3.864165819860951},
    {{1000000.0, 1000000.0}, 0.5002474873115434, 0.75803627919815085, 6.7835377291047994},
    {{1e9, 3e9}, 0.24998630693606408, 0.022749146196727155, 8.9728176107438805},
    {{1e15, 1e15}, 0.5000000111803399, 0.84134474582242026, 16.890170436107747},
    {{1e12, 40000.0}, 0.9999999598000016, 0.1586541851636986, 20.910435827186653},
    {{1e15, 10}, 0.9999999999999916, 0.66104966147319331, 32.493636417357278},
};

// Returns the logarithm of the reward's density at x, computed from the density of its logit.
double LogDensityAt(const BetaPosterior& posterior, double x) {
  const double log_x = std::log(x);
  const double log_y = std::log1p(-x);
  return LogitLogPeak(posterior) + LogitLogShape(posterior, log_x - log_y - LogitMode(posterior)) -
         log_x - log_y;
}

// Returns the error bound that the header states. It results from the precision of x.
double Tolerance(const BetaPosterior& p) {
  return 1e-10 + 1e-15 * std::sqrt(p.alpha) + 1e-15 * std::sqrt(p.beta);
}

TEST(BetaDistribution, LogGammaAgreesWithTheReferences) {
  const std::vector<std::pair<double, double>> values = {
      {1e-06, 13.815509980749432},     {0.001, 6.9071788853838537},
      {0.5, 0.57236494292470009},      {1, 0.0},
      {1.5, -0.12078223763524522},     {2, 0.0},
      {10, 12.80182748008147},         {100.5, 361.43554046777762},
      {1000000.0, 12815504.569147612}, {1e15, 33538776394910669.0}};
  for (const auto& [x, expected] : values)
    EXPECT_NEAR(LogGamma(x), expected, 2e-14 + 1e-15 * std::abs(expected)) << x;
}

TEST(BetaDistribution, AgreesWithTheReferences) {
  for (const Reference& reference : kReferences) {
    EXPECT_NEAR(BetaDistribution(reference.posterior, reference.x), reference.distribution,
                Tolerance(reference.posterior))
        << reference.posterior.alpha << ' ' << reference.posterior.beta;
  }
}

TEST(BetaDistribution, LogDensityAgreesWithTheReferences) {
  for (const Reference& reference : kReferences) {
    EXPECT_NEAR(LogDensityAt(reference.posterior, reference.x), reference.log_density,
                100 * Tolerance(reference.posterior))
        << reference.posterior.alpha << ' ' << reference.posterior.beta;
  }
}

TEST(BetaDistribution, QuantileIsTheInverseOfTheDistribution) {
  for (const double alpha : {0.3, 1.0, 7.0, 400.0, 2999.0, 3001.0, 1e6, 1e12}) {
    for (const double beta : {0.3, 1.0, 12.0, 2999.0, 3001.0, 1e5, 1e12}) {
      double before = 0;
      for (const double p : {1e-9, 0.025, 0.4, 0.5, 0.6, 0.975, 1 - 1e-9}) {
        const double quantile = BetaQuantile({alpha, beta}, p);
        EXPECT_GE(quantile, before);
        before = quantile;
        if (quantile == 1) continue;  // indistinguishable from 1 in a double
        // A change of x by one rounding step changes the distribution by the density times that
        // step.
        const double digits = 2.3e-16 * std::exp(LogDensityAt({alpha, beta}, quantile));
        EXPECT_NEAR(BetaDistribution({alpha, beta}, quantile), p, 2e-10 + digits)
            << alpha << ' ' << beta;
      }
    }
  }
}

TEST(BetaDistribution, CentralIntervalOfTheUniformIsSymmetric) {
  const CredibleInterval interval = CentralInterval({1, 1}, 0.95);
  EXPECT_NEAR(interval.low, 0.025, 1e-14);
  EXPECT_NEAR(interval.high, 0.975, 1e-14);
}

TEST(BetaDistribution, SwappedParametersMirrorTheQuantile) {
  for (const Reference& reference : kReferences) {
    const BetaPosterior mirrored = {reference.posterior.beta, reference.posterior.alpha};
    EXPECT_NEAR(BetaQuantile(reference.posterior, 0.3), 1 - BetaQuantile(mirrored, 0.7), 1e-15);
  }
}

TEST(BetaDistribution, ExtremeParametersGiveOrderedNumbersInTheUnitInterval) {
  for (const double alpha : {1e-300, 1e-6, 1e-5, 0.9, 1e6, 1e15, 1e300}) {
    for (const double beta : {1e-300, 1e-6, 1.0, 1e6, 1e15, 1e300}) {
      const CredibleInterval interval = CentralInterval({alpha, beta}, 0.9);
      EXPECT_TRUE(interval.low >= 0 && interval.low <= interval.high && interval.high <= 1)
          << alpha << ' ' << beta;
      double before = 0;
      for (const double x : {0.0, 1e-300, 1e-9, 0.3, 0.5, 0.9, 1.0}) {
        const double below = BetaDistribution({alpha, beta}, x);
        EXPECT_TRUE(below >= before && below <= 1) << alpha << ' ' << beta << ' ' << x;
        before = below;
      }
    }
  }
}

// Compares the bits, which must be the same on every platform.
TEST(BetaDistribution, BitsEqualTheRecordedOnes) {
  const auto bits = [](double value) { return std::bit_cast<uint64_t>(value); };
  EXPECT_EQ(bits(LogGamma(0.7)), 0x3fd0b20c891cde80u);
  EXPECT_EQ(bits(BetaDistribution({2.5, 40}, 0.03)), 0x3fcc42f9a4a62dc1u);
  EXPECT_EQ(bits(BetaDistribution({2.5e5, 4e6}, 0.0588)), 0x3fdac9b67e4195dbu);
  EXPECT_EQ(bits(BetaQuantile({31.5, 1.8}, 0.975)), 0x3fefd1192089a65bu);
}

}  // namespace
}  // namespace sweepstake::decision
