#include "tests/laboratory/replay/replay_priors.h"

#include <algorithm>
#include <utility>

#include "engine_client/decider/policy/log_cost.h"
#include "engine_client/decider/pooling/prior.h"
#include "engine_client/math/hash.h"
#include "engine_client/math/portable_math.h"
#include "engine_client/math/random.h"
#include "tests/laboratory/policies/study_policies.h"

namespace sweepstake::cli {
namespace {

using decision::ArmEvidence;

constexpr char kProject[] = "project";
constexpr char kScene[] = "scene";
constexpr char kMachineClass[] = "class";

// The stored evidence of a game.
struct PlayedGame {
  std::string scene = kScene;
  std::string machine_class = kMachineClass;
  StoredEvidence regimes;
};

// Reverses the ranking of the arms that have evidence; the other arms are unchanged.
std::vector<ArmEvidence> ReversedArms(const std::vector<ArmEvidence>& arms) {
  const std::vector<decision::EvidenceSum> pooled = decision::PoolEvidence(arms);
  std::vector<size_t> ranking;
  for (size_t arm = 0; arm < arms.size(); ++arm) {
    if (pooled[arm].evidence() > 0) ranking.push_back(arm);
  }
  const auto mean = [&](size_t arm) { return pooled[arm].alpha / pooled[arm].evidence(); };
  std::stable_sort(ranking.begin(), ranking.end(),
                   [&](size_t a, size_t b) { return mean(a) > mean(b); });
  std::vector<ArmEvidence> reversed = arms;
  for (size_t i = 0; i < ranking.size(); ++i)
    reversed[ranking[i]] = arms[ranking[ranking.size() - 1 - i]];
  return reversed;
}

StoredEvidence Reversed(StoredEvidence regimes) {
  for (auto& [regime, arms] : regimes) arms = ReversedArms(arms);
  return regimes;
}

std::vector<double> ClassRatios(uint32_t arm_count, uint64_t seed) {
  std::vector<double> ratios;
  for (uint32_t arm = 0; arm < arm_count; ++arm) {
    decision::RandomStream stream(seed, decision::RandomPurpose::kReplayClass, 0, arm);
    ratios.push_back(math::Exp(kClassDeviation * decision::DrawNormal(stream)));
  }
  return ratios;
}

// Returns the prior of a new session of kScene on kMachineClass, with the same build as the games.
decision::Prior PriorAfter(std::span<const PlayedGame> games, uint32_t arm_count, bool compares) {
  decision::PriorKey key{.project = kProject,
                         .scene = kScene,
                         .machine_class = kMachineClass,
                         .reward_version = decision::kLogCostRewardVersion,
                         .arms = {},
                         .backend_versions = std::vector<uint32_t>(arm_count, 1),
                         .compares_sources = compares};
  for (uint32_t arm = 0; arm < arm_count; ++arm) key.arms.push_back(math::HexOf(arm));
  std::vector<decision::ArmRecord> records;
  for (const PlayedGame& game : games) {
    for (const auto& [regime, arms] : game.regimes) {
      for (uint32_t arm = 0; arm < arm_count; ++arm)
        records.push_back({.project = kProject,
                           .scene = game.scene,
                           .machine_class = game.machine_class,
                           .reward_version = key.reward_version,
                           .source = "game",
                           .build = {},
                           .arm = key.arms[arm],
                           .evidence = arms[arm],
                           .regime = regime});
    }
  }
  return decision::PriorFor(records, key);
}

}  // namespace

decision::Prior ServedPrior(ReplayPriors kind, const std::string& policy, const ReplayScene& scene,
                            std::span<const ReplayScene* const> others, uint64_t seed,
                            const PlayGame& play) {
  const bool compares =
      decision::PolicyKindOf(policy, decision::StudyPolicies()).starts_from_priors;
  std::vector<PlayedGame> games;
  switch (kind) {
    case ReplayPriors::kNone:
      return {};
    case ReplayPriors::kRight:
      games.push_back({.regimes = play(scene).stored});
      break;
    case ReplayPriors::kWrong:
      games.push_back({.regimes = Reversed(play(scene).stored)});
      break;
    case ReplayPriors::kClass:
      games.push_back(
          {.machine_class = "another class",
           .regimes = play(scene.WithArmRatios(ClassRatios(scene.arm_count(), seed))).stored});
      break;
    case ReplayPriors::kScenes:
      if (!compares) return {};
      // The names keep the order of the scenes: hexadecimal names of equal length sort by value.
      for (const ReplayScene* other : others)
        games.push_back({.scene = math::HexOf(games.size()), .regimes = play(*other).stored});
      break;
  }
  return PriorAfter(games, scene.arm_count(), compares);
}

}  // namespace sweepstake::cli
