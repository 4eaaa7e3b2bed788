#include "engine_client/decider/pooling/source_prior.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine_client/decider/policy/log_cost.h"
#include "engine_client/math/random.h"
#include "tests/engine_client/decider/pooling/evidence_sums.h"

namespace sweepstake::decision {
namespace {

// Makes a source with these costs per arm; 0 means unknown.
SourceEvidence SourceOf(std::initializer_list<double> costs_us, double windows = 100,
                        double weight = 1) {
  SourceEvidence source;
  for (const double cost : costs_us)
    source.push_back({cost > 0 ? SumOf(cost, windows) : EvidenceSum(), weight});
  return source;
}

// Returns the prior of a session without its own evidence.
std::vector<EvidenceSum> PriorOf(std::span<const SourceEvidence> sources, size_t arm_count) {
  return CombineSources(sources, std::vector<EvidenceSum>(arm_count));
}

TEST(CombineSources, OfNoSourcesIsEmpty) {
  const auto prior = PriorOf({}, 2);
  ASSERT_EQ(prior.size(), 2u);
  EXPECT_EQ(prior[0].evidence(), 0);
}

TEST(CombineSources, OfOneSourceHasItsCostsWithLessPrecision) {
  const SourceEvidence sources[] = {SourceOf({100, 0, 300}, 1e6)};
  const auto prior = PriorOf(sources, 3);
  EXPECT_NEAR(CostUs(prior[0]), 100, 0.1);
  EXPECT_EQ(prior[1].evidence(), 0);
  EXPECT_NEAR(CostUs(prior[2]), 300, 0.3);
  EXPECT_NEAR(DeviationOf(prior[0]), 0.1 * std::sqrt(2), 0.01)
      << "a million windows of one session do not make the next session certain";
}

TEST(CombineSources, AcceptsMachinesOfDifferentSpeed) {
  const SourceEvidence sources[] = {SourceOf({100, 200}), SourceOf({300, 600}), SourceOf({50, 100}),
                                    SourceOf({100, 200}), SourceOf({10, 20})};
  const auto prior = PriorOf(sources, 2);
  EXPECT_NEAR(CostUs(prior[0]), 100, 0.1) << "the typical level";
  EXPECT_NEAR(CostUs(prior[1]), 200, 0.2);
  EXPECT_LT(DeviationOf(prior[1]), 0.09);
}

TEST(CombineSources, ComparesArmsOfSourcesWithDifferentArms) {
  const SourceEvidence sources[] = {SourceOf({100, 200, 0}), SourceOf({0, 1000, 2000}),
                                    SourceOf({100, 0, 400})};
  const auto prior = PriorOf(sources, 3);
  EXPECT_NEAR(CostUs(prior[1]) / CostUs(prior[0]), 2, 0.1);
  EXPECT_NEAR(CostUs(prior[2]) / CostUs(prior[0]), 4, 0.2);
}

TEST(CombineSources, IsAsWideAsTheSourcesDisagreeForAnyNumberOfSources) {
  std::vector<SourceEvidence> alike;
  std::vector<SourceEvidence> unlike;
  for (int i = 0; i < 200; ++i) {
    alike.push_back(SourceOf({100, 200, 300}));
    unlike.push_back(SourceOf({100, i % 2 == 0 ? 120.0 : 330.0, 300}));
  }
  EXPECT_LT(DeviationOf(PriorOf(alike, 3)[1]), 0.03);
  EXPECT_GT(DeviationOf(PriorOf(unlike, 3)[1]), 0.4);
}

TEST(CombineSources, FollowsSourcesWithMoreWeight) {
  const SourceEvidence sources[] = {SourceOf({100, 200}, 100, 0.5), SourceOf({100, 300}, 100, 0.1),
                                    SourceOf({100, 300}, 100, 0.1)};
  EXPECT_NEAR(CostUs(PriorOf(sources, 2)[1]) / CostUs(PriorOf(sources, 2)[0]), 2, 0.1);
}

// A session with its own evidence of two arms resumes on a machine of half the speed.
TEST(CombineSources, AddsToTheOwnEvidenceAtItsLevel) {
  const SourceEvidence sources[] = {SourceOf({100, 200, 400}), SourceOf({100, 200, 400})};
  const std::vector<EvidenceSum> own = {SourceOf({200})[0].sum, SourceOf({400})[0].sum, {}};
  const auto prior = CombineSources(sources, own);
  EXPECT_NEAR(CostUs(prior[0]), 200, 0.5);
  EXPECT_GT(prior[0].evidence(), own[0].evidence());
  EXPECT_NEAR(CostUs(prior[2]), 800, 2);
  EXPECT_EQ(CombineSources({}, own)[1].alpha, own[1].alpha);
}

double SecondIsBetter(const std::vector<EvidenceSum>& prior) {
  const NormalBelief first = BeliefOf({prior[0].alpha, prior[0].beta});
  const NormalBelief second = BeliefOf({prior[1].alpha, prior[1].beta});
  return 0.5 *
         std::erfc(-(first.mean - second.mean) / std::sqrt(2 * (first.variance + second.variance)));
}

// A tenth of the clients sends false evidence of a million windows each: the worst arm takes 1 ns,
// and the best one 5 s.
TEST(CombineSources, HardlyChangesWithATenthOfHostileSources) {
  RandomStream random(7, RandomPurpose::kChoice, 0, 0);
  std::vector<SourceEvidence> sources;
  for (int i = 0; i < 90; ++i) {
    const double speed = std::exp(random.NextUniform() - 0.5);
    const double noise = std::exp(0.2 * (random.NextUniform() - 0.5));
    sources.push_back(SourceOf({100 * speed, 110 * speed * noise, 400 * speed}));
  }
  const auto honest = PriorOf(sources, 3);
  for (int i = 0; i < 10; ++i) sources.push_back(SourceOf({5e6, 0.001, 0.001}, 1e6));
  const auto attacked = PriorOf(sources, 3);
  EXPECT_NEAR(SecondIsBetter(attacked), SecondIsBetter(honest), 0.05);
  EXPECT_NEAR(CostUs(attacked[0]), CostUs(honest[0]), 5);
}

// Returns sources with the evidence of a few visits each, from machines that differ slightly.
std::vector<SourceEvidence> UnsureSources(int count) {
  RandomStream random(7, RandomPurpose::kChoice, 0, 0);
  std::vector<SourceEvidence> sources;
  for (int i = 0; i < count; ++i) {
    const double noise = std::exp(0.3 * (random.NextUniform() - 0.5));
    sources.push_back(SourceOf({100, 110 * noise, 400}, /*windows=*/0.02));
  }
  return sources;
}

TEST(CombineSources, GivesNoMoreWeightToASourceThatClaimsMoreCertainty) {
  std::vector<SourceEvidence> sources = UnsureSources(24);
  std::vector<SourceEvidence> sure = sources;
  for (int i = 0; i < 8; ++i) {
    sources.push_back(SourceOf({100, 140, 400}, 0.02));
    sure.push_back(SourceOf({100, 140, 400}, 1e6));
  }
  EXPECT_NEAR(CostUs(PriorOf(sure, 3)[1]), CostUs(PriorOf(sources, 3)[1]), 0.1);
}

TEST(CombineSources, OmitsOutliers) {
  std::vector<SourceEvidence> sources = UnsureSources(24);
  const auto honest = PriorOf(sources, 3);
  for (int i = 0; i < 8; ++i) sources.push_back(SourceOf({5e6, 0.001, 0.001}, 1e6));
  const auto attacked = PriorOf(sources, 3);
  EXPECT_NEAR(CostUs(attacked[1]), CostUs(honest[1]), 0.1);
  EXPECT_NEAR(DeviationOf(attacked[1]), DeviationOf(honest[1]), 0.02);
}

}  // namespace
}  // namespace sweepstake::decision
