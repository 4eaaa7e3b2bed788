#include "engine_client/decider/policy/regime_report.h"

#include <algorithm>
#include <cmath>

#include "engine_client/decider/policy/diagnosis.h"
#include "engine_client/math/portable_math.h"

namespace sweepstake::decision {
namespace {

ArmReport::Cost CostOfBelief(const NormalBelief& log_cost) {
  const double reach = kDeviations95 * std::sqrt(log_cost.variance);
  return {.us = math::Exp(log_cost.mean),
          .low_us = math::Exp(log_cost.mean - reach),
          .high_us = math::Exp(log_cost.mean + reach)};
}

// Fills in the costs, the probabilities and the best arm. `arms` may be empty.
void AddArms(std::span<const RegimeBelief::Arm> arms, RegimeReport& report) {
  std::vector<double> means, variances;
  for (const RegimeBelief::Arm& arm : arms) {
    means.push_back(arm.log_cost.mean);
    variances.push_back(arm.difference_variance);
  }
  const std::vector<double> probabilities = DiagnoseLogCosts(means, variances).best_probability;
  for (uint32_t i = 0; i < arms.size(); ++i) {
    ArmReport& arm = report.arms.emplace_back(ArmReport{.best_probability = probabilities[i]});
    if (!arms[i].is_known) continue;
    arm.cost = CostOfBelief(arms[i].log_cost);
    if (!report.best_arm || means[i] < means[*report.best_arm]) report.best_arm = i;
  }
}

// Fills in what a policy without beliefs about costs knows.
void AddDiagnosis(const Diagnosis& diagnosis, RegimeReport& report) {
  for (const double probability : diagnosis.best_probability)
    report.arms.push_back({.best_probability = probability});
  if (!diagnosis.best_probability.empty()) report.best_arm = diagnosis.leader;
}

std::optional<double> SavedAgainst(std::optional<uint32_t> arm, const RegimeUse& use) {
  return arm ? SavedPerFrame(use, *arm) : std::nullopt;
}

void AddUse(const RegimeUse& use, std::optional<uint32_t> single, const SavingBaselines& baselines,
            RegimeReport& report) {
  if (use.frame_count == 0) return;
  report.ran_us = use.ran_us / static_cast<double>(use.frame_count);
  report.saved_against_single_us = SavedAgainst(single, use);
  report.saved_against_reference_us = SavedAgainst(baselines.reference, use);
  report.saved_against_initial_us = SavedAgainst(baselines.initial, use);
}

// Returns the beliefs about the mean costs over all measured frames. The logarithm of an arm's mean
// cost has a weight for each regime: the regime's share in the arm's time. Beliefs of different
// regimes count as independent.
std::vector<RegimeBelief::Arm> MeanBeliefs(std::span<const RegimeBelief> beliefs,
                                           std::span<const RegimeUse> uses,
                                           const RegimeUse& total) {
  std::vector<RegimeBelief::Arm> means(total.arm_us.size());
  for (size_t i = 0; i < means.size(); ++i) {
    RegimeBelief::Arm& mean = means[i];
    mean.is_known = IsMostlyKnown(total, static_cast<uint32_t>(i));
    mean.log_cost.mean = LogCostOf(total.arm_us[i] / static_cast<double>(total.frame_count));
    for (const RegimeBelief& belief : beliefs) {
      const RegimeBelief::Arm& arm = belief.arms[i];
      const auto use = std::find_if(uses.begin(), uses.end(),
                                    [&](const RegimeUse& each) { return each.id == belief.id; });
      if (use == uses.end()) continue;
      const double weight = use->arm_us[i] / total.arm_us[i];
      mean.log_cost.variance += weight * weight * arm.log_cost.variance;
      mean.difference_variance += weight * weight * arm.difference_variance;
    }
  }
  return means;
}

}  // namespace

bool IsMostlyKnown(const RegimeUse& use, uint32_t arm) {
  return 2 * use.known_frame_counts[arm] > use.frame_count;
}

std::optional<double> SavedPerFrame(const RegimeUse& use, uint32_t arm) {
  if (use.frame_count == 0 || !IsMostlyKnown(use, arm)) return std::nullopt;
  return (use.arm_us[arm] - use.ran_us) / static_cast<double>(use.frame_count);
}

bool BestArmsDiffer(const SceneReport& report) {
  std::optional<uint32_t> best;
  for (const RegimeReport& regime : report.regimes) {
    if (best && regime.best_arm && regime.best_arm != best) return true;
    if (regime.best_arm) best = regime.best_arm;
  }
  return false;
}

SceneReport ReportOf(std::span<const RegimeBelief> beliefs, std::span<const RegimeUse> uses,
                     const RegimeUse& total, const Diagnosis& diagnosis,
                     const SavingBaselines& baselines) {
  const auto present = std::find_if(beliefs.begin(), beliefs.end(),
                                    [](const RegimeBelief& each) { return each.is_present; });
  SceneReport scene;
  scene.total.centre = present->centre;
  scene.total.is_present = true;
  scene.total.frame_share = 1;
  if (present->arms.empty()) {
    AddDiagnosis(diagnosis, scene.total);
  } else if (total.frame_count == 0) {
    AddArms(present->arms, scene.total);
  } else {
    AddArms(MeanBeliefs(beliefs, uses, total), scene.total);
  }
  const std::optional<uint32_t> single = scene.total.best_arm;
  AddUse(total, single, baselines, scene.total);
  if (beliefs.size() < 2) return scene;
  scene.total.centre = {};
  for (const RegimeBelief& belief : beliefs) {
    RegimeReport& regime = scene.regimes.emplace_back(
        RegimeReport{.centre = belief.centre, .is_present = belief.is_present});
    AddArms(belief.arms, regime);
    const auto use = std::find_if(uses.begin(), uses.end(),
                                  [&](const RegimeUse& each) { return each.id == belief.id; });
    if (use == uses.end()) continue;
    AddUse(*use, single, baselines, regime);
    if (total.frame_count > 0)
      regime.frame_share =
          static_cast<double>(use->frame_count) / static_cast<double>(total.frame_count);
  }
  return scene;
}

}  // namespace sweepstake::decision
