#include "engine_client/decider/policy/scene_diagnosis.h"

#include <algorithm>

#include "engine_client/decider/policy/diagnosis.h"
#include "engine_client/decider/policy/log_cost.h"

namespace sweepstake::decision {
namespace {

struct Contenders {
  std::vector<size_t> places;  // index of each contender in the scene's arms
  std::vector<BetaPosterior> posteriors;

  explicit Contenders(std::span<const SceneArm> arms) {
    for (size_t i = 0; i < arms.size(); ++i) {
      if (IsOutdated(arms[i], arms) || arms[i].posterior == BetaPosterior{}) continue;
      places.push_back(i);
      posteriors.push_back(arms[i].posterior);
    }
  }

  Diagnosis Compare(uint32_t reward_version) const {
    if (reward_version != kLogCostRewardVersion) return Diagnose(posteriors);
    std::vector<double> means, variances;
    for (const BetaPosterior& posterior : posteriors) {
      const NormalBelief belief = BeliefOf(posterior);
      means.push_back(belief.mean);
      variances.push_back(belief.variance);
    }
    return DiagnoseLogCosts(means, variances);
  }
};

}  // namespace

bool IsOutdated(const SceneArm& arm, std::span<const SceneArm> arms) {
  return std::any_of(arms.begin(), arms.end(), [&](const SceneArm& other) {
    return other.name == arm.name && other.backend_version > arm.backend_version;
  });
}

std::optional<size_t> LeaderOf(std::span<const SceneArm> arms, uint32_t reward_version) {
  const Contenders contenders(arms);
  const std::vector<size_t>& places = contenders.places;
  if (places.empty()) return std::nullopt;
  return places.size() == 1 ? places[0] : places[contenders.Compare(reward_version).leader];
}

SceneDiagnosis DiagnoseScene(std::span<const SceneArm> arms, uint32_t reward_version) {
  SceneDiagnosis scene;
  for (const SceneArm& arm : arms) {
    scene.arms.push_back(
        {.is_outdated = IsOutdated(arm, arms), .best_probability = {}, .cost_ratio = {}});
  }
  const Contenders contenders(arms);
  const std::vector<BetaPosterior>& posteriors = contenders.posteriors;
  if (posteriors.size() < 2) return scene;
  const Diagnosis diagnosis = contenders.Compare(reward_version);
  scene.leader = contenders.places[diagnosis.leader];
  scene.verdict = diagnosis.verdict;
  scene.expected_loss_ratio = diagnosis.expected_loss_ratio;
  scene.value_remaining_ratio = diagnosis.value_remaining_ratio;
  for (size_t i = 0; i < posteriors.size(); ++i) {
    ArmDiagnosis& arm = scene.arms[contenders.places[i]];
    arm.best_probability = diagnosis.best_probability[i];
    if (reward_version != kLogCostRewardVersion) continue;
    arm.cost_ratio = i == diagnosis.leader
                         ? CostRatio{}
                         : CostRatioOf(posteriors[i], posteriors[diagnosis.leader]);
  }
  return scene;
}

}  // namespace sweepstake::decision
