// Compares the posteriors of a scene's arms: computes the verdict, and for each arm the probability
// of being the best and the cost relative to the leader's. The evidence of all sessions counts as
// if its windows were independent. Every reader of a scene's figures gets the ones computed here.
//
// A contender is an arm in its newest backend version. Only contenders are compared. With fewer
// than two of them the verdict is unknown, since nothing can be better than another arm.
//
// Pure function, thread-safe, with the same bits on every platform.
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
  BetaPosterior posterior;  // parameters finite and > 0
};

struct ArmDiagnosis {
  CredibleInterval reward_95;              // the central 95 % of the posterior
  bool is_outdated = false;                // not a contender: there is a newer backend version
  std::optional<double> best_probability;  // absent: the verdict is unknown, or not a contender
  // The arm's cost ÷ the leader's. Absent if best_probability is, or if the rewards do not measure
  // costs.
  std::optional<CostRatio> cost_ratio;
};

struct SceneDiagnosis {
  std::vector<ArmDiagnosis> arms;  // in the order of the arms given
  std::optional<size_t> leader;    // its place among them; absent: the verdict is unknown
  Verdict verdict = Verdict::kUnknown;
  double expected_loss_ratio = 0;    // as in Diagnosis
  double value_remaining_ratio = 0;  // as in Diagnosis
};

SceneDiagnosis DiagnoseScene(std::span<const SceneArm> arms, uint32_t reward_version);

}  // namespace sweepstake::decision
