#include "engine_client/decider/policy/diagnosis.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "engine_client/math/random.h"

namespace sweepstake::decision {
namespace {

using Posteriors = std::vector<BetaPosterior>;

double Sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

// Returns P(reward 0 > reward 1) if α of the first is an integer: Σ B(αb + i, βa + βb) ÷ ((βa + i)
// B(1 + i, βa) B(αb, βb)) (E. Miller, "Formulas for Bayesian A/B testing", 2015), computed with the
// C library's gamma function.
double ExactFirstWins(const BetaPosterior& first, const BetaPosterior& second) {
  const auto log_beta = [](double a, double b) {
    return std::lgamma(a) + std::lgamma(b) - std::lgamma(a + b);
  };
  double sum = 0;
  for (int i = 0; i < first.alpha; ++i) {
    sum +=
        std::exp(log_beta(second.alpha + i, first.beta + second.beta) - std::log(first.beta + i) -
                 log_beta(1 + i, first.beta) - log_beta(second.alpha, second.beta));
  }
  return sum;
}

double NormalDistribution(double z) { return 0.5 * std::erfc(-z / std::sqrt(2.0)); }

// Returns random posteriors of all widths, from a seed.
Posteriors AnyPosteriors(uint64_t seed, double widest_exponent) {
  RandomStream random(seed, RandomPurpose::kChoice, 0, 0);
  Posteriors posteriors(2 + random.NextBelow(31));
  for (BetaPosterior& p : posteriors) {
    p.alpha = std::pow(10, widest_exponent * (2 * random.NextUniform() - 1));
    p.beta = std::pow(10, widest_exponent * (2 * random.NextUniform() - 1));
  }
  return posteriors;
}

TEST(Diagnosis, OfTwoArmsAgreesWithTheClosedFormula) {
  const std::vector<Posteriors> pairs = {{{5, 4}, {2, 3}},          {{1, 1}, {2, 1}},
                                         {{40, 3}, {31.5, 1.8}},    {{300, 700}, {29, 71}},
                                         {{2000, 100}, {1e4, 480}}, {{1, 1000}, {0.5, 500}}};
  for (const Posteriors& pair : pairs) {
    EXPECT_NEAR(Diagnose(pair).best_probability[0], ExactFirstWins(pair[0], pair[1]), 1e-6)
        << pair[0].alpha << ' ' << pair[1].alpha;
  }
}

TEST(Diagnosis, OfThreeArmsAgreesWithAComputationByHand) {
  // The densities are 1, 1 and 2x. The third arm wins with probability ∫ 2x³ = 1/2; E[max] = ∫ x ·
  // 4x³ = 4/5; the third's mean is 2/3.
  const Diagnosis diagnosis = Diagnose(Posteriors{{1, 1}, {1, 1}, {2, 1}});
  EXPECT_NEAR(diagnosis.best_probability[2], 0.5, 1e-6);
  EXPECT_NEAR(diagnosis.best_probability[0], 0.25, 1e-6);
  EXPECT_EQ(diagnosis.best_probability[0], diagnosis.best_probability[1]);
  EXPECT_EQ(diagnosis.leader, 2u);
  EXPECT_NEAR(diagnosis.expected_loss_ratio, 1.0 / 6, 2e-6);
  EXPECT_NEAR(diagnosis.entropy, 1.5 * std::log(2.0), 1e-5);
  EXPECT_EQ(diagnosis.verdict, Verdict::kAmbiguous);
}

TEST(Diagnosis, OfSevenArmsAgreesWithSampling) {
  const Posteriors posteriors = {{30, 20}, {3, 2},   {200, 120}, {0.6, 0.4},
                                 {9, 1.5}, {31, 33}, {1, 5}};
  constexpr int kDraws = 200'000;
  std::vector<double> wins(posteriors.size());
  double best_sum = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    std::vector<double> rewards;
    for (uint32_t arm = 0; arm < posteriors.size(); ++arm) {
      RandomStream stream(5, RandomPurpose::kChoice, static_cast<uint64_t>(draw), arm);
      rewards.push_back(DrawBeta(posteriors[arm], stream));
    }
    const auto best = std::max_element(rewards.begin(), rewards.end());
    wins[static_cast<size_t>(best - rewards.begin())] += 1.0 / kDraws;
    best_sum += *best / kDraws;
  }
  const Diagnosis diagnosis = Diagnose(posteriors);
  for (size_t arm = 0; arm < posteriors.size(); ++arm)
    EXPECT_NEAR(diagnosis.best_probability[arm], wins[arm], 5 * 0.5 / std::sqrt(kDraws)) << arm;
  const double reward = posteriors[diagnosis.leader].mean();
  EXPECT_NEAR(diagnosis.expected_loss_ratio, (best_sum - reward) / best_sum, 0.002);
}

TEST(Diagnosis, ProbabilitiesSumToOneWithoutNanForAnyPosteriors) {
  for (const double widest_exponent : {0.5, 2.0, 6.0, 15.0}) {
    for (uint64_t seed = 1; seed <= 100; ++seed) {
      const Diagnosis diagnosis = Diagnose(AnyPosteriors(seed, widest_exponent));
      EXPECT_NEAR(Sum(diagnosis.best_probability), 1, 1e-12) << seed;
      for (const double p : diagnosis.best_probability) EXPECT_TRUE(p >= 0 && p <= 1) << seed;
      EXPECT_TRUE(diagnosis.expected_loss_ratio >= 0 && diagnosis.expected_loss_ratio <= 1) << seed;
      EXPECT_TRUE(diagnosis.value_remaining_ratio >= 0 &&
                  diagnosis.value_remaining_ratio <= diagnosis.expected_loss_ratio)
          << seed;
      EXPECT_TRUE(std::isfinite(diagnosis.entropy) && diagnosis.entropy >= 0) << seed;
    }
  }
}

TEST(Diagnosis, DoesNotDependOnTheOrderOfTheArms) {
  for (uint64_t seed = 1; seed <= 50; ++seed) {
    Posteriors posteriors = AnyPosteriors(seed, 3);
    const Diagnosis diagnosis = Diagnose(posteriors);
    std::reverse(posteriors.begin(), posteriors.end());
    const Diagnosis reversed = Diagnose(posteriors);
    for (size_t arm = 0; arm < posteriors.size(); ++arm) {
      EXPECT_NEAR(diagnosis.best_probability[arm],
                  reversed.best_probability[posteriors.size() - 1 - arm], 1e-12);
    }
    EXPECT_NEAR(diagnosis.expected_loss_ratio, reversed.expected_loss_ratio, 1e-9);
  }
}

TEST(Diagnosis, OfEqualArmsIsEqual) {
  for (const BetaPosterior& posterior :
       Posteriors{{1e-6, 1e-6}, {0.2, 7}, {3, 2}, {4e5, 1e6}, {1e15, 1e15}, {1e15, 1e-6}}) {
    const Diagnosis diagnosis = Diagnose(Posteriors(32, posterior));
    for (const double p : diagnosis.best_probability) EXPECT_NEAR(p, 1.0 / 32, 1e-15);
    EXPECT_NEAR(diagnosis.entropy, std::log(32.0), 1e-12);
  }
}

TEST(Diagnosis, TheProbabilityOfAnArmGrowsWithItsMean) {
  double before = 0;
  for (int step = 0; step <= 40; ++step) {
    const double alpha = 30 + step;
    const double p =
        Diagnose(Posteriors{{alpha, 100 - alpha}, {50, 50}, {5, 4}}).best_probability[0];
    EXPECT_GT(p, before);
    before = p;
  }
}

TEST(Diagnosis, HandlesANarrowArmAmongWideOnes) {
  // The narrow arm is almost exactly ½, so it is the best if the uniform arm is below ½.
  const Diagnosis diagnosis = Diagnose(Posteriors{{1, 1}, {1e14, 1e14}});
  EXPECT_NEAR(diagnosis.best_probability[1], 0.5, 1e-5);
  EXPECT_NEAR(diagnosis.expected_loss_ratio, 0.125 / 0.625, 1e-5);
}

TEST(Diagnosis, ValueRemainingIsTheLossOfTheArmWithTheHighestMean) {
  // The narrow posterior is at 0.52. The wide one has mean 0.5 and is above 0.52 with a probability
  // of almost a half, but the leader is the arm with the highest mean.
  const Diagnosis same = Diagnose(Posteriors{{52e10, 48e10}, {1, 1}});
  EXPECT_EQ(same.leader, 0u);
  EXPECT_EQ(same.value_remaining_ratio, same.expected_loss_ratio);
  // Beta(0.2, 0.3) is above 0.38 with a probability below a half, but its mean is 0.4.
  const Diagnosis other = Diagnose(Posteriors{{38e10, 62e10}, {0.2, 0.3}});
  EXPECT_EQ(other.leader, 0u);
  const double best = 0.38 / (1 - other.expected_loss_ratio);
  EXPECT_NEAR(other.value_remaining_ratio, (best - 0.4) / best, 1e-9);
}

TEST(Diagnosis, OfAlmostEqualArmsAgreesWithTheNormalDistribution) {
  // The standard deviation of the difference is √(2 · ¼ / 2e14).
  const double sigma = std::sqrt(0.5 / 2e14);
  const double p =
      Diagnose(Posteriors{{1e14 + 2e14 * sigma, 1e14}, {1e14, 1e14}}).best_probability[0];
  EXPECT_NEAR(p, NormalDistribution(0.5), 1e-5);
}

TEST(Diagnosis, IsUnknownIfNothingWasLearnt) {
  EXPECT_TRUE(Diagnose(Posteriors{}).best_probability.empty());
  const Diagnosis diagnosis = Diagnose(Posteriors(7));
  EXPECT_TRUE(diagnosis.best_probability.empty());
  EXPECT_EQ(diagnosis.verdict, Verdict::kUnknown);
}

TEST(Diagnosis, OfOneArmIsStable) {
  const Diagnosis diagnosis = Diagnose(Posteriors{{3, 2}});
  EXPECT_EQ(diagnosis.best_probability, std::vector<double>{1});
  EXPECT_EQ(diagnosis.verdict, Verdict::kStable);
  EXPECT_NEAR(diagnosis.expected_loss_ratio, 0, 1e-6);
}

TEST(Diagnosis, VerdictFollowsProbabilityAndLoss) {
  EXPECT_EQ(VerdictOf(0.8, 1), Verdict::kStable);
  EXPECT_EQ(VerdictOf(0.79, 0.005), Verdict::kTie);
  EXPECT_EQ(VerdictOf(0.79, 0.0051), Verdict::kAmbiguous);
  EXPECT_EQ(Diagnose(Posteriors{{900, 100}, {800, 200}}).verdict, Verdict::kStable);
  EXPECT_EQ(Diagnose(Posteriors{{9e4, 1e4}, {9.001e4, 1e4}}).verdict, Verdict::kTie);
  EXPECT_EQ(Diagnose(Posteriors{{9, 1}, {8, 2}}).verdict, Verdict::kAmbiguous);
}

TEST(LogCostDiagnosis, OfTwoArmsAgreesWithTheNormalDistribution) {
  const std::vector<double> means = {1.0, 1.2};
  const std::vector<double> variances = {0.01, 0.03};
  const Diagnosis diagnosis = DiagnoseLogCosts(means, variances);
  EXPECT_NEAR(diagnosis.best_probability[0], NormalDistribution(1), 1e-6);
  // E[(y0 − y1)⁺] = s φ(z) − d Φ(−z), where d = 0.2 is the difference of the means, s = 0.2 its
  // standard deviation, and z = d / s.
  const double loss =
      0.2 * (std::exp(-0.5) / std::sqrt(2 * std::numbers::pi) - NormalDistribution(-1));
  EXPECT_NEAR(diagnosis.expected_loss_ratio, std::expm1(loss), 1e-6);
  EXPECT_NEAR(diagnosis.value_remaining_ratio, diagnosis.expected_loss_ratio, 1e-12);
}

TEST(LogCostDiagnosis, IgnoresACovarianceThatAllArmsShare) {
  const std::vector<double> means = {0.3, 0.31, 0.33, 0.5, 0.2};
  const std::vector<double> variances = {0.01, 0.02, 0.001, 0.3, 0.02};
  std::vector<double> covariance(25, 0.7);
  for (size_t i = 0; i < 5; ++i) covariance[6 * i] += variances[i];
  const Diagnosis independent = DiagnoseLogCosts(means, variances);
  const Diagnosis correlated = DiagnoseCorrelatedLogCosts(means, covariance);
  for (size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(correlated.best_probability[i], independent.best_probability[i], 1e-4);
  }
  EXPECT_NEAR(correlated.expected_loss_ratio, independent.expected_loss_ratio, 1e-4);
}

TEST(LogCostDiagnosis, OfTwoCorrelatedArmsUsesTheVarianceOfTheirDifference) {
  const std::vector<double> means = {0, 0.1, 9};
  const std::vector<double> covariance = {0.05, 0.048, 0, 0.048, 0.056, 0.01, 0, 0.01, 0.02};
  const Diagnosis diagnosis = DiagnoseCorrelatedLogCosts(means, covariance);
  EXPECT_NEAR(diagnosis.best_probability[0], NormalDistribution(1), 1e-6);
}

TEST(LogCostDiagnosis, ProbabilitiesSumToOneWithoutNanForAnyCosts) {
  for (uint64_t seed = 1; seed <= 200; ++seed) {
    RandomStream random(seed, RandomPurpose::kChoice, 0, 0);
    std::vector<double> means(1 + random.NextBelow(32));
    std::vector<double> variances(means.size());
    for (double& mean : means) mean = 20 * random.NextUniform() - 10;
    for (double& variance : variances)
      variance = random.NextBelow(8) == 0 ? 0 : std::pow(10, 24 * random.NextUniform() - 18);
    const Diagnosis diagnosis = DiagnoseLogCosts(means, variances);
    EXPECT_NEAR(Sum(diagnosis.best_probability), 1, 1e-12) << seed;
    EXPECT_FALSE(std::isnan(diagnosis.expected_loss_ratio)) << seed;
  }
}

TEST(LogCostDiagnosis, OfKnownCostsIsCertain) {
  const Diagnosis diagnosis = DiagnoseLogCosts(std::vector{1.0, 0.5}, std::vector{0.0, 0.0});
  EXPECT_NEAR(diagnosis.best_probability[1], 1, 1e-12);
  EXPECT_NEAR(diagnosis.expected_loss_ratio, 0, 1e-7);
}

// Compares the bits, which are the same on every platform.
TEST(Diagnosis, BitsEqualTheRecordedOnes) {
  const auto bits = [](double value) { return std::bit_cast<uint64_t>(value); };
  const Diagnosis rewards = Diagnose(Posteriors{{30.25, 20}, {3, 2}, {200, 120.5}, {0.6, 0.4}});
  EXPECT_EQ(bits(rewards.best_probability[0]), 0x3fbce88e3b2e63adu);
  EXPECT_EQ(bits(rewards.expected_loss_ratio), 0x3fd08bcf3a269b3fu);
  const Diagnosis costs = DiagnoseCorrelatedLogCosts(
      std::vector{0.1, 0.12, 0.2},
      std::vector{0.01, 0.004, 0.003, 0.004, 0.02, 0.002, 0.003, 0.002, 0.03});
  EXPECT_EQ(bits(costs.best_probability[0]), 0x3fdaa1ec0517ee79u);
  EXPECT_EQ(bits(costs.expected_loss_ratio), 0x3fb341bb8f107165u);
}

}  // namespace
}  // namespace sweepstake::decision
