// The policy of "AI Decides": the arm that costs least, believed on what the shadow lane and the
// live windows say, and switched to where that is worth it.
//
// Costs are logarithms of detection times in µs; the reward shown and stored is
// r = 1 − cost / ln(5 s in µs), reward version 2. Beliefs are those of RelativeCostFilter. A switch
// must pass the gate horizon · E⁺ − cooldown · E⁻ − cost > 0 (GateTerms), with the switch's
// measured cost. Arms that may take over 3 s a frame are never switched to. While the shadow lane
// reports, only arms that it has measured are; without it the gate's E⁺, the value of not knowing,
// tries each arm live.
//
// Draws nothing: the same observations give the same choices whatever the seed. All constants that
// are times are multiples of the options' intervals, so that a time scale changes none of it.
// Cost: some 10 µs per tick with 7 arms and a sweep of them.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "server/decision/policy.h"
#include "server/decision/relative_cost_filter.h"

namespace sweepstake::decision {

class AdaptivePolicy : public Policy {
 public:
  explicit AdaptivePolicy(const PolicySetup& setup);

  std::optional<Lesson> LearnWindow(const WindowObservation& observation) override;
  Increment LearnBailOut(uint32_t arm) override;
  void LearnShadow(std::span<const ShadowSample> samples, int64_t now_ns) override;
  void LearnSwitchCost(uint32_t arm, const SwitchCost& cost) override;

  Choice Choose(const ChoiceInput& input) const override;
  std::optional<int64_t> cooldown_ns() const override;

  const std::vector<BetaPosterior>& posteriors() const override { return posteriors_; }

 private:
  struct Assessment {
    GateTerms terms;
    double worth = 0;  // seconds won
  };

  void TakePriors(const PolicySetup& setup);
  void DropPriors();
  void DropContradictedPriors(std::span<const ShadowSample> samples);
  void AdvanceTo(int64_t now_ns);
  void ShowBeliefs();
  uint32_t Leader() const;
  bool IsSafe(uint32_t arm) const;
  bool IsOpen(uint32_t arm, int64_t now_ns) const;
  bool LaneReports(int64_t now_ns) const;
  Assessment Assess(uint32_t active, uint32_t candidate) const;

  DecisionOptions options_;
  RelativeCostFilter filter_;
  std::vector<bool> has_prior_;
  std::vector<bool> observed_;  // in this session, live or in the lane
  std::vector<BetaPosterior> posteriors_;
  std::optional<int64_t> last_advance_ns_;
  std::optional<int64_t> last_shadow_ns_;
  bool swept_ = false;
  uint64_t window_count_ = 0;
  double switch_cost_s_;
  double detection_share_ = 1;  // of frame time
};

}  // namespace sweepstake::decision
