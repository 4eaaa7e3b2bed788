#include "engine_client/decider/policy/scene_diagnosis.h"

#include <algorithm>

#include "engine_client/decider/policy/diagnosis.h"
#include "engine_client/decider/policy/log_cost.h"

namespace sweepstake::decision {
namespace {

bool IsOutdated(const SceneArm& arm, std::span<const SceneArm> arms) {
  return std::any_of(arms.begin(), arms.end(), [&](const SceneArm& other) {
    return other.name == arm.name && other.backend_version > arm.backend_version;
  });
}

Diagnosis DiagnoseCosts(std::span<const BetaPosterior> posteriors) {
  const bool nothing_learnt =
      std::all_of(posteriors.begin(), posteriors.end(),
                  [](const BetaPosterior& posterior) { return posterior == BetaPosterior{}; });
  if (nothing_learnt) return {};
  std::vector<double> means, variances;
  for (const BetaPosterior& posterior : posteriors) {
    const NormalBelief belief = BeliefOf(posterior);
    means.push_back(belief.mean);
    variances.push_back(belief.variance);
  }
  return DiagnoseLogCosts(means, variances);
}

}  // namespace

SceneDiagnosis DiagnoseScene(std::span<const SceneArm> arms, uint32_t reward_version) {
  SceneDiagnosis scene;
  std::vector<BetaPosterior> contenders;
  std::vector<size_t> places;
  for (const SceneArm& arm : arms) {
    const bool is_outdated = IsOutdated(arm, arms);
    if (!is_outdated) {
      contenders.push_back(arm.posterior);
      places.push_back(scene.arms.size());
    }
    scene.arms.push_back({.reward_95 = CentralInterval(arm.posterior, 0.95),
                          .is_outdated = is_outdated,
                          .best_probability = {},
                          .cost_ratio = {}});
  }
  if (contenders.size() < 2) return scene;
  const bool tells_costs = reward_version == kLogCostRewardVersion;
  const Diagnosis diagnosis = tells_costs ? DiagnoseCosts(contenders) : Diagnose(contenders);
  if (diagnosis.best_probability.empty()) return scene;
  scene.leader = places[diagnosis.leader];
  scene.verdict = diagnosis.verdict;
  scene.expected_loss_ratio = diagnosis.expected_loss_ratio;
  scene.value_remaining_ratio = diagnosis.value_remaining_ratio;
  for (size_t i = 0; i < contenders.size(); ++i) {
    ArmDiagnosis& arm = scene.arms[places[i]];
    arm.best_probability = diagnosis.best_probability[i];
    if (!tells_costs) continue;
    arm.cost_ratio = i == diagnosis.leader
                         ? CostRatio{}
                         : CostRatioOf(contenders[i], contenders[diagnosis.leader]);
  }
  return scene;
}

}  // namespace sweepstake::decision
