#include "tests/laboratory/replay/replay_priors.h"

#include <algorithm>

#include "engine_client/decider/pooling/source_prior.h"
#include "engine_client/math/portable_math.h"
#include "engine_client/math/random.h"
#include "tests/laboratory/policies/study_policies.h"

namespace sweepstake::cli {
namespace {

using decision::EvidenceSum;
using Sums = std::vector<EvidenceSum>;

double MeanOf(const EvidenceSum& sum) { return sum.alpha / sum.evidence(); }

// Reverses the ranking of the arms that have evidence; the other arms are unchanged.
Sums Reversed(const Sums& sums) {
  std::vector<size_t> ranking;
  for (size_t arm = 0; arm < sums.size(); ++arm) {
    if (sums[arm].evidence() > 0) ranking.push_back(arm);
  }
  std::stable_sort(ranking.begin(), ranking.end(),
                   [&](size_t a, size_t b) { return MeanOf(sums[a]) > MeanOf(sums[b]); });
  Sums reversed = sums;
  for (size_t i = 0; i < ranking.size(); ++i)
    reversed[ranking[i]] = sums[ranking[ranking.size() - 1 - i]];
  return reversed;
}

std::vector<double> ClassRatios(uint32_t arm_count, uint64_t seed) {
  std::vector<double> ratios;
  for (uint32_t arm = 0; arm < arm_count; ++arm) {
    decision::RandomStream stream(seed, decision::RandomPurpose::kReplayClass, 0, arm);
    ratios.push_back(math::Exp(kClassDeviation * decision::DrawNormal(stream)));
  }
  return ratios;
}

// Returns the prior sums of a session that has no evidence of its own, from one source.
Sums OfSource(const Sums& taught, const decision::SourceRelation& relation) {
  const double weight = decision::PowerPriorWeight(relation);
  decision::SourceEvidence source;
  for (const EvidenceSum& sum : taught) source.push_back({sum, weight});
  return decision::CombineSources({&source, 1}, Sums(taught.size()));
}

Sums OfOtherScenes(std::span<const ReplayScene* const> others, size_t arm_count,
                   const Teach& teach) {
  std::vector<Sums> scenes;
  for (const ReplayScene* other : others)
    scenes.push_back(decision::PoolEvidence(teach(*other).taught));
  return decision::WithOtherScenes(Sums(arm_count), scenes);
}

}  // namespace

std::vector<decision::BetaPosterior> ServedPriors(ReplayPriors kind, const std::string& policy,
                                                  const ReplayScene& scene,
                                                  std::span<const ReplayScene* const> others,
                                                  uint64_t seed, const Teach& teach) {
  const bool compares =
      decision::PolicyKindOf(policy, decision::StudyPolicies()).starts_from_priors;
  const decision::SourceRelation own{.same_build = true,
                                     .same_machine_class = kind != ReplayPriors::kClass};
  Sums sums;
  switch (kind) {
    case ReplayPriors::kNone:
      return {};
    case ReplayPriors::kRight:
    case ReplayPriors::kWrong:
      sums = decision::PoolEvidence(teach(scene).taught);
      if (kind == ReplayPriors::kWrong) sums = Reversed(sums);
      break;
    case ReplayPriors::kClass:
      sums = decision::PoolEvidence(
          teach(scene.WithArmRatios(ClassRatios(scene.arm_count(), seed))).taught);
      break;
    case ReplayPriors::kScenes:
      if (compares) sums = OfOtherScenes(others, scene.arm_count(), teach);
      break;
  }
  // A policy whose rewards cannot be compared between sources starts with the sums of all sources.
  if (compares && kind != ReplayPriors::kScenes) sums = OfSource(sums, own);
  if (!decision::IsAnythingKnown(sums)) return {};
  std::vector<decision::BetaPosterior> priors;
  for (const EvidenceSum& sum : sums) priors.push_back({1 + sum.alpha, 1 + sum.beta});
  return priors;
}

}  // namespace sweepstake::cli
