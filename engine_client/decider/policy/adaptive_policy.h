// The policy of "AI Decides" (`adaptive`): it estimates every arm's cost from the shadow lane and
// the live windows, and switches to a cheaper arm if the gain pays for the switch.
//
// - Costs are log-costs (log_cost.h, reward version 3) of a window's calm frames (window.h). The
//   filter in relative_cost_filter.h holds the beliefs about them, and separates the load of other
//   work on the frame thread's core from the cost of an arm. Beliefs are shown as one Beta
//   distribution per arm, such that the differences to the leader have the filter's variances.
// - A switch must pass the gate of GateTerms, horizon · E⁺ − cooldown · E⁻ − cost > 0, with the
//   measured cost of switches, and E⁺ must exceed that of a tie. The cooldown is long enough to pay
//   for the switches. It is at least settling and one window, and at most that of the options.
// - An arm that exceeds three fifths of the bail-out limit (3 s of 5) with a probability above 1 %
//   is not chosen. There are two exceptions: a bail-out of the active arm and, without the lane, an
//   arm never seen whose expected cost is not above that of the active arm.
// - While the shadow lane reports, only arms that were measured or have priors are chosen. An arm
//   that is believed to be worse is tried live once if the gate finds that its window is worth the
//   cost, because the lane's bias is unknown until then. It is not tried if it costs twice as much
//   as the active arm with a probability above 10 %. An arm that was live must be better by a
//   quarter of the deviation of the difference, so that the policy does not switch back and forth.
//   Without the lane, the value of exploration (E⁺ of an arm never seen) leads to every arm being
//   tried live.
// - Until an arm is observed, its prior has a standard deviation of at least 15 %, and a fifth of
//   the belief ignores it. Priors are dropped if the lane's first visits find another arm much
//   cheaper than the one that the priors expect.
// - An arm's first live window is a trial (SwitchCommand). The client switches back at once if two
//   frames in a row take a fifth longer than the longest one before, or if all of them exceed a
//   budget. The gate therefore limits the loss to that budget if the arm was observed before. The
//   first early end may have another cause than the arm. From the second one on it is a lower bound
//   of the arm's cost, like a visit of the lane that a cap has ended. It limits the arm no further
//   than that cost, but E⁺ of another trial must be ten times that of a tie.
// - Each regime of the scene has separate beliefs, which are used again when the regime returns. If
//   regimes change faster than choices take effect, a mixture of them decides (regime_beliefs.h).
//
// Nothing is drawn: the same observations give the same choices for every seed. All constants that
// are times are multiples of the options' intervals, so that a time scale changes nothing.
// tests/bench/programs/decision_tick_bench.cc measures the cost of a tick.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "engine_client/decider/policy/log_cost.h"
#include "engine_client/decider/policy/policy.h"
#include "engine_client/decider/policy/regime_beliefs.h"

namespace sweepstake::decision {

// The policy's components, which an ablation study can disable one by one
// (tests/laboratory/policies/study_policies.h).
struct AdaptiveComponents {
  FilterComponents filter{};
  bool shadow = true;          // learns from the shadow lane
  bool gate = true;            // false: any expected gain is enough
  bool short_cooldown = true;  // false: the cooldown is that of the options
  bool regimes = true;         // keeps separate beliefs for each regime
};

class AdaptivePolicy : public Policy {
 public:
  static constexpr PolicyKind kKind = {.name = "adaptive",
                                       .reward_version = kLogCostRewardVersion,
                                       .explores = false,
                                       .starts_from_priors = true,
                                       .uses_shadow = true};
  // The ban after an arm's first bail-out, in decision intervals. Each later ban is four times as
  // long.
  static constexpr double kFirstBan = 200;
  // The maximum cost of a trial before the client ends it (SwitchCommand), as a share of the
  // trial's time.
  static constexpr double kTrialBudget = 1.0 / 40;

  explicit AdaptivePolicy(const PolicySetup& setup, const AdaptiveComponents& components = {});

  std::optional<WindowUpdate> LearnWindow(const WindowObservation& observation) override;
  Increment LearnBailOut(uint32_t arm) override;
  std::vector<Increment> LearnShadow(std::span<const ShadowSample> samples,
                                     int64_t now_ns) override;
  void LearnSwitchCost(uint32_t arm, const SwitchCost& cost) override;
  void LearnTrialEnd(const TrialEnd& end, int64_t now_ns) override;
  void LearnDescriptor(const SceneDescriptor& descriptor, int64_t now_ns) override;

  Choice Choose(const ChoiceInput& input) const override;
  std::optional<int64_t> cooldown_ns() const override;

  const std::vector<BetaPosterior>& posteriors() const override { return posteriors_; }
  double WindowEvidence(uint32_t arm) const override;
  Diagnosis Diagnose() const override;

 private:
  // The state of an arm that bailed out. With a lane it counts as a stall until the lane measures
  // it again. Without a lane it counts as a stall for the length of the ban, and then has its
  // earlier cost again.
  struct Ban {
    double intervals_left = 0;  // decision intervals; 0: none
    double next_intervals = kFirstBan;
    double log_cost = 0;
  };
  struct Visit {
    uint64_t sweep = 0;
    double log_cost = 0;
    bool is_bound = false;  // a cap has ended it: log_cost is a lower bound
  };
  struct Assessment {
    uint32_t arm = 0;
    GateTerms terms{};
    double advantage = 0;  // gain − loss, also of a trial
    double worth_s = 0;    // the gate passes if this is above 0
    bool matters = true;   // the gain exceeds that of a tie
    // Arms whose switch passes the gate come first.
    std::pair<bool, double> rank() const { return {matters && worth_s > 0, worth_s}; }
  };

  void SetPriors(const std::vector<BetaPosterior>& priors);
  static Visit VisitOf(const ShadowSample& sample);
  void Observe(uint32_t arm, const Visit& visit);
  void DropContradictedPriors(std::span<const ShadowSample> samples);
  Increment VisitIncrement(uint32_t arm, double log_cost) const;
  RelativeCostFilter& filter() { return beliefs_.filter(); }
  const RelativeCostFilter& filter() const { return beliefs_.filter(); }
  void Assume(uint32_t arm, double log_cost);
  void AdvanceTo(int64_t now_ns);
  void AdvanceBans(double intervals);
  void UpdatePosteriors();
  double HorizonSeconds() const;
  bool LaneReports(int64_t now_ns) const;
  bool IsKnownEnough(uint32_t arm, int64_t now_ns) const;
  bool IsSafe(uint32_t arm, const ChoiceInput& input) const;
  bool IsContender(const ChoiceInput& input, uint32_t arm) const;
  bool IsTrial(const ChoiceInput& input, uint32_t arm) const;
  Assessment Assess(const ChoiceInput& input, uint32_t candidate) const;
  std::optional<Assessment> BestSwitch(const ChoiceInput& input) const;

  DecisionOptions options_;
  AdaptiveComponents components_;
  RegimeBeliefs beliefs_;
  std::vector<bool> has_prior_;
  std::vector<bool> observed_;  // arms observed in this session, live or by the lane
  std::vector<Ban> bans_;
  std::vector<bool> was_live_;     // arms with a live window in this session
  std::vector<bool> trial_ended_;  // arms with a trial that ended early
  // The inputs of DropContradictedPriors: the cheapest arm by the priors, while they are held, and
  // the log-cost of the lane's first visit to each arm with a prior.
  std::optional<uint32_t> expected_arm_;
  std::vector<std::optional<Visit>> first_visits_;
  std::vector<BetaPosterior> posteriors_;
  std::optional<int64_t> last_advance_ns_;
  std::optional<int64_t> last_shadow_ns_;
  uint64_t window_count_ = 0;
  double switch_cost_s_;
  double detection_share_ = 1;  // detection's share of the frame time
};

}  // namespace sweepstake::decision
