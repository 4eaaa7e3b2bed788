#include "tests/laboratory/tests/experiment/experiment_records.h"

#include <gtest/gtest.h>

#include <utility>

namespace sweepstake::test_support {

using cli::ExperimentCell;
using cli::RecordedDecision;
using cli::RunRecord;

namespace {

constexpr uint32_t kPolicyReason = 1;
constexpr uint32_t kExplorationReason = 2;

RecordedDecision Decision(double time_s, uint32_t active, uint32_t best) {
  RecordedDecision decision;
  decision.time_s = time_s;
  decision.active_arm = active;
  decision.candidate = best;
  decision.outcome = active == best ? 1 : 3;  // kept, or held back by the cooldown
  decision.reward = 0.9;
  decision.leader = best;
  decision.expected_loss_ratio = 0.001;
  decision.verdict = 1;
  decision.alpha = {2, 2, 2};
  decision.beta = {2, 2, 2};
  decision.alpha[best] = 9;
  decision.beta[best] = 1;
  decision.best_probability = {0.05, 0.05, 0.05};
  decision.best_probability[best] = 0.9;
  return decision;
}

}  // namespace

RunRecord MakeRecord(const ExperimentCell& cell, const std::string& policy, uint32_t run,
                     uint32_t arm, double share_percent) {
  RunRecord record;
  record.cell = cell;
  record.policy = policy;
  record.run = run;
  record.scene_seed = run;
  record.seed = 100 + run;
  record.start_utc = "2026-01-31T12:00:00Z";
  record.arms = kRecordArms;
  const auto next = static_cast<uint32_t>((arm + 1) % kRecordArms.size());
  record.exploration_s = 6;
  record.end_s = 106;
  record.switches = {{2, 20, 0, 1, kExplorationReason, 1000, 10},
                     {4, 40, 1, 2, kExplorationReason, 1000, 10}};
  if (arm != 2) record.switches.push_back({6, 60, 2, arm, kPolicyReason, 1000, 10});
  record.switches.push_back({6 + share_percent, 70, arm, next, kPolicyReason, 1000, 10});
  record.decisions = {Decision(5, 2, arm), Decision(8, arm, arm), Decision(105, next, arm)};
  record.windows = {{8, arm, 100, 30, 50, 20, 1000, 60, 4096, cell.object_count}};
  for (size_t i = 0; i < kRecordArms.size(); ++i) {
    record.explored.push_back({10, 400'000, 300'000});
    record.observed.push_back({1000, 40'000'000, 30'000'000});
    record.controls.push_back({100, 6'000'000, i == arm ? 2'500'000U : 5'000'000U});
  }
  record.time = {.scene_step_ns = 30'000'000,
                 .detection_ns = 80'000'000,
                 .rebuild_ns = 500'000,
                 .copying_ns = 1'500'000,
                 .around_ns = 500'000,
                 .frame_end_ns = 100'000,
                 .intake_ns = 1'000'000,
                 .decision_ns = 300'000,
                 .longest_decision_ns = 60'000,
                 .lane_ns = 9'000'000};
  return record;
}

cli::ExperimentPlan PlanOf(const cli::ExperimentOptions& options) {
  auto plan = cli::MakePlan(options);
  EXPECT_TRUE(plan.ok()) << plan.status().message();
  return std::move(*plan);
}

}  // namespace sweepstake::test_support
