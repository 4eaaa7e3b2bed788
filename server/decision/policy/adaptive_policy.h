// The policy of "AI Decides": the arm that costs least, believed on what the shadow lane and the
// live windows say, and switched to where that is worth it.
//
// - Costs are log_cost.h's (reward version 2), beliefs those of relative_cost_filter.h. Shown is a
//   Beta distribution per arm, whose differences to the leader are as wide as the filter's.
// - A switch must pass the gate of GateTerms, horizon · E⁺ − cooldown · E⁻ − cost > 0, with the
//   measured cost of switches, and E⁺ must be more than a tie's. The cooldown is as long as pays
//   for the switches' cost, at least settling and one window, at most the options'.
// - An arm that may exceed three fifths of the bail-out limit (3 s of 5) with a probability of 1 %
//   is not switched to, unless the active one bailed out, or costs more than one never seen.
// - While the shadow lane reports, only arms that were measured or have priors are switched to,
//   and only where they are believed to be better: not knowing has no value there. Without it,
//   that value (E⁺ of an arm never seen) tries every arm live.
// - Priors are believed to 15 %, and for a fifth not at all, until an arm is observed; they are
//   dropped where the lane's first visits put another arm well ahead of the one they do.
//
// Draws nothing: the same observations give the same choices whatever the seed. All constants that
// are times are multiples of the options' intervals, so that a time scale changes none of it. Cost
// of a session's tick with a sweep of all arms, p99 (tests/bench/decision_tick_bench.cc): 14 µs
// with 7 arms, 110 µs with 32.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "server/decision/policy/policy.h"
#include "server/decision/policy/relative_cost_filter.h"

namespace sweepstake::decision {

// What the policy consists of, to be measured without.
struct AdaptiveLevers {
  FilterLevers filter{};
  bool shadow = true;          // learns from the lane
  bool gate = true;            // else any gain is worth a switch
  bool short_cooldown = true;  // else the options'
};

class AdaptivePolicy : public Policy {
 public:
  explicit AdaptivePolicy(const PolicySetup& setup, const AdaptiveLevers& levers = {});

  std::optional<Lesson> LearnWindow(const WindowObservation& observation) override;
  Increment LearnBailOut(uint32_t arm) override;
  void LearnShadow(std::span<const ShadowSample> samples, int64_t now_ns) override;
  void LearnSwitchCost(uint32_t arm, const SwitchCost& cost) override;

  Choice Choose(const ChoiceInput& input) const override;
  std::optional<int64_t> cooldown_ns() const override;

  const std::vector<BetaPosterior>& posteriors() const override { return posteriors_; }
  Diagnosis Diagnose() const override;

 private:
  struct Assessment {
    uint32_t arm = 0;
    GateTerms terms{};
    double worth_s = 0;  // what the gate compares with 0
  };

  void TakePriors(const std::vector<BetaPosterior>& priors);
  void DropContradictedPriors(std::span<const ShadowSample> samples);
  void AdvanceTo(int64_t now_ns);
  void ShowBeliefs();
  bool LaneReports(int64_t now_ns) const;
  bool IsOpen(uint32_t arm, int64_t now_ns) const;
  bool IsSafe(uint32_t arm, const ChoiceInput& input) const;
  Assessment Assess(uint32_t active, uint32_t candidate) const;
  std::optional<Assessment> BestSwitch(const ChoiceInput& input) const;

  DecisionOptions options_;
  AdaptiveLevers levers_;
  RelativeCostFilter filter_;
  std::vector<bool> has_prior_;
  std::vector<bool> observed_;  // in this session, live or by the lane
  std::vector<BetaPosterior> posteriors_;
  std::optional<int64_t> last_advance_ns_;
  std::optional<int64_t> last_shadow_ns_;
  uint64_t window_count_ = 0;
  double switch_cost_s_;
  double detection_share_ = 1;  // of frame time
};

}  // namespace sweepstake::decision
