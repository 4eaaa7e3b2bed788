#include "engine_client/decider/pooling/priors_diff.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "engine_client/math/portable_math.h"

namespace sweepstake::decision {
namespace {

constexpr double kMinLogChange = 0.05;

}  // namespace

std::optional<double> RatioOf(const std::optional<PriorsArm>& arm) {
  return arm && arm->cost_ratio ? std::optional(arm->cost_ratio->median) : std::nullopt;
}

double ArmComparison::log_change() const {
  const std::optional<double> old_ratio = RatioOf(before);
  const std::optional<double> new_ratio = RatioOf(after);
  return old_ratio && new_ratio ? math::Log(*new_ratio / *old_ratio) : 0;
}

bool ArmComparison::changed() const {
  return RatioOf(before).has_value() != RatioOf(after).has_value() ||
         std::abs(log_change()) > kMinLogChange;
}

bool SceneComparison::changed() const {
  return std::any_of(arms.begin(), arms.end(),
                     [](const ArmComparison& arm) { return arm.changed(); });
}

bool SceneComparison::in_both() const {
  const auto any = [&](std::optional<PriorsArm> ArmComparison::*side) {
    return std::any_of(arms.begin(), arms.end(),
                       [&](const ArmComparison& arm) { return RatioOf(arm.*side).has_value(); });
  };
  return any(&ArmComparison::before) && any(&ArmComparison::after);
}

bool SceneComparison::leader_changed() const {
  return in_both() && std::none_of(arms.begin(), arms.end(), [](const ArmComparison& arm) {
           return RatioOf(arm.before) == 1.0 && RatioOf(arm.after) == 1.0;
         });
}

std::vector<SceneComparison> ComparePriors(const PriorsGroups& before, const PriorsGroups& after) {
  std::map<PriorsGroupKey, std::map<std::string, ArmComparison>> scenes;
  const auto add = [&](const PriorsGroups& groups, std::optional<PriorsArm> ArmComparison::*side) {
    for (const auto& [key, group] : groups) {
      for (const auto& [name, arm] : group.arms) {
        if (arm.pooled.evidence() > 0) scenes[key][name].*side = arm;
      }
    }
  };
  add(before, &ArmComparison::before);
  add(after, &ArmComparison::after);
  std::vector<SceneComparison> compared;
  for (auto& [key, arms] : scenes) {
    SceneComparison& scene = compared.emplace_back(SceneComparison{.key = key, .arms = {}});
    for (auto& [name, arm] : arms) {
      arm.arm = name;
      scene.arms.push_back(std::move(arm));
    }
  }
  return compared;
}

std::vector<SceneComparison> DiffPriors(const PriorsGroups& before, const PriorsGroups& after) {
  std::vector<SceneComparison> scenes = ComparePriors(before, after);
  std::erase_if(scenes, [](const SceneComparison& scene) { return !scene.changed(); });
  return scenes;
}

}  // namespace sweepstake::decision
