#include "server/decision/baselines/thresholds_policy.h"

#include <algorithm>
#include <array>

#include "server/decision/policy/choice.h"

namespace sweepstake::decision {
namespace {

using Row = std::array<std::string_view, 2>;  // by preference

Row RowOf(double object_count, double density_ratio) {
  if (object_count < ThresholdsPolicy::kFewObjects) return {"BruteForce", ""};
  const bool sparse =
      object_count <= ThresholdsPolicy::kManyObjects && density_ratio <= ThresholdsPolicy::kDense;
  return sparse ? Row{"AxisSweep", "SAP"} : Row{"KDTree", "DBVT"};
}

}  // namespace

Increment ThresholdsPolicy::LearnBailOut(uint32_t arm) {
  bailed_out_[arm] = true;
  return RewardPolicy::LearnBailOut(arm);
}

void ThresholdsPolicy::LearnDescriptor(const SceneDescriptor& descriptor, int64_t /*now_ns*/) {
  if (descriptor.object_count) object_count_ = descriptor.object_count;
  if (descriptor.density_ratio) density_ratio_ = *descriptor.density_ratio;
}

std::optional<uint32_t> ThresholdsPolicy::Find(std::string_view name) const {
  const auto found = std::find(arms_.begin(), arms_.end(), name);
  const auto arm = static_cast<uint32_t>(found - arms_.begin());
  if (found == arms_.end() || bailed_out_[arm]) return std::nullopt;
  return arm;
}

Choice ThresholdsPolicy::Choose(const ChoiceInput& input) const {
  if (!object_count_) return ChoiceOf(input.active_arm);
  for (const std::string_view name : RowOf(*object_count_, density_ratio_)) {
    if (const std::optional<uint32_t> arm = Find(name)) return ChoiceOf(*arm);
  }
  return ChoiceOf(input.active_arm);
}

}  // namespace sweepstake::decision
