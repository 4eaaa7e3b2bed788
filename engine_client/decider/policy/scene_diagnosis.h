// Compares the posteriors of a scene's arms. Computes the verdict and, for each arm, the
// probability of being the best and the cost relative to the leader's. The evidence of all sessions
// counts as if its windows were independent. The daemon computes these figures, so the dashboard
// and the command line show the same values.
//
// Only contenders are compared: each arm with evidence, in its newest backend version. With fewer
// than two contenders the verdict is unknown.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "engine_client/decider/types.h"
#include "engine_client/math/beta_distribution.h"

namespace sweepstake::decision {

struct SceneArm {
  std::string_view name;
  uint32_t backend_version = 0;
  BetaPosterior posterior;  // parameters finite and > 0; Beta(1,1): no evidence
};

struct ArmDiagnosis {
  bool is_outdated = false;                // a newer backend version of the arm exists
  std::optional<double> best_probability;  // absent: not a contender, or verdict unknown
  // The arm's cost ÷ the leader's cost. Absent if best_probability is absent, or if rewards of this
  // version do not measure costs.
  std::optional<CostRatio> cost_ratio;
};

struct SceneDiagnosis {
  std::vector<ArmDiagnosis> arms;  // in the order of the argument `arms`
  std::optional<size_t> leader;    // index into `arms`; absent if the verdict is unknown
  Verdict verdict = Verdict::kUnknown;
  double expected_loss_ratio = 0;    // as in Diagnosis
  double value_remaining_ratio = 0;  // as in Diagnosis
};

SceneDiagnosis DiagnoseScene(std::span<const SceneArm> arms, uint32_t reward_version);

// Returns only the leader, as an index into `arms`. A single contender leads too. Absent without
// evidence. Takes a tenth of the time of DiagnoseScene.
std::optional<size_t> LeaderOf(std::span<const SceneArm> arms, uint32_t reward_version);

// Returns whether `arms` has a newer backend version of the arm.
bool IsOutdated(const SceneArm& arm, std::span<const SceneArm> arms);

}  // namespace sweepstake::decision
