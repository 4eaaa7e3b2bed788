// The policy of "AI Decides" (`adaptive`). It estimates every arm's cost from the shadow lane and
// the live windows. It switches to a cheaper arm if the gain pays for the switch.
//
// - Costs are log-costs (log_cost.h, reward version 3) of a window's calm frames (window.h). The
//   filter in relative_cost_filter.h holds the beliefs about them. It separates the load of other
//   work on the frame thread's core from the cost of an arm. Watchers see the beliefs as one Beta
//   distribution per arm. The difference of each arm to the leader has the filter's variance.
// - A switch must pass the gate of GateTerms: horizon · E⁺ − cooldown · E⁻ − cost > 0. E⁺ and E⁻
//   are the expected gain and loss after the next window of the candidate. The horizon is the mean
//   length of the scene's regimes. The present one counts as if it lasted for another cooldown of
//   the options. The cost is the mean measured cost of earlier switches. The policy's own cooldown
//   is settling plus one window, and at most the cooldown of the options.
// - Without a trial, a switch must have an E⁺ of at least 0.5 %.
// - An arm is not chosen if its frames exceed the bail-out limit with a probability above 1 %.
//   There are two exceptions. After a bail-out of the active arm, any arm may be chosen. Without
//   the lane, an arm never seen may be chosen if its expected cost is not above the active arm's.
// - While the shadow lane reports, only arms that were measured are chosen. An arm that is believed
//   to be worse may be tried live, because the lane's bias for it is unknown until then. The gate
//   decides whether the trial is worth its cost. An arm that was live must be believed to be
//   cheaper.
// - Without the lane, the expected gain E⁺ of an arm never seen is large, because its cost is
//   uncertain. So every arm is tried live.
// - A prior has a standard deviation of at least 30 %. Until an arm is observed, a fifth of the
//   belief ignores its prior.
// - An arm's first live window is a trial (SwitchCommand), if the client stops trials. Then the
//   client switches back at once in two cases. Either a search takes too long compared with the
//   previous arm's, or the trial exceeds its time budget. For an arm that was observed, the gate
//   therefore limits the loss to that budget.
// - An early end of a trial gives a lower bound of the arm's cost. A visit that the lane cut off at
//   its time limit does too. If the mean search of three trials was cheaper than the active
//   arm's, the arm is used without a trial. Single searches are long, because it rebuilds its
//   structure.
// - Each regime of the scene has separate beliefs, which are used again when the regime returns.
//   Evidence belongs to the regime in which it was measured (regime_span.h).
//
// The policy draws no random numbers: the same observations give the same choices for every seed.
// All constants that are times are multiples of the options' intervals, so choices do not depend on
// the time scale. tests/bench/programs/decision_tick_bench.cc measures the cost of a tick.
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
  bool gate = true;            // false: any positive expected gain is enough
  bool short_cooldown = true;  // false: uses the cooldown of the options
  bool regimes = true;         // keeps separate beliefs for each regime
};

class AdaptivePolicy : public Policy {
 public:
  static constexpr PolicyKind kKind = {.name = "adaptive",
                                       .reward_version = kLogCostRewardVersion,
                                       .explores = false,
                                       .starts_from_priors = true,
                                       .uses_shadow = true,
                                       .keeps_regimes = true};
  // The ban after an arm's first bail-out, in decision intervals. Each later ban of the arm is four
  // times as long as the previous one.
  static constexpr double kFirstBan = 200;
  // The client ends a trial whose searches took too much extra time (SwitchCommand). This is the
  // limit of that extra time, as a share of the trial's length.
  static constexpr double kTrialBudget = 1.0 / 40;

  explicit AdaptivePolicy(const PolicySetup& setup, const AdaptiveComponents& components = {});

  std::optional<WindowUpdate> LearnWindow(const WindowObservation& observation) override;
  Increment LearnBailOut(uint32_t arm) override;
  std::vector<Increment> LearnShadow(std::span<const ShadowSample> samples,
                                     int64_t now_ns) override;
  void LearnSwitchCost(uint32_t arm, const SwitchCost& cost) override;
  void LearnTrialEnd(const TrialEnd& end, uint32_t arm_before, int64_t now_ns) override;
  DescriptorMatch Match(const SceneDescriptor& descriptor) const override;
  void LearnDescriptor(const SceneDescriptor& descriptor, int64_t now_ns) override;

  Choice Choose(const ChoiceInput& input) const override;
  std::optional<int64_t> cooldown_ns() const override;

  const std::vector<BetaPosterior>& posteriors() const override { return posteriors_; }
  double WindowEvidence(uint32_t arm) const override;
  Diagnosis Diagnose() const override;
  RegimeFeatures present_features() const override;
  RegimeId present_regime() const override;
  std::vector<RegimeBelief> Regimes() const override;
  std::optional<double> ExpectedLogCost(uint32_t arm) const override;

 private:
  // The state of an arm that bailed out. Its cost is assumed to be the cost of a bail-out. With a
  // lane, this holds until the lane measures the arm again. Without a lane, it holds for the length
  // of the ban, and then the arm gets its earlier cost back.
  struct Ban {
    double intervals_left = 0;  // rest of the ban, in decision intervals; 0: not banned
    double next_intervals = kFirstBan;
    double log_cost = 0;
  };
  struct Visit {
    uint64_t sweep = 0;
    double log_cost = 0;
    bool is_bound = false;  // the lane cut the visit off: log_cost is a lower bound
  };
  struct Assessment {
    uint32_t arm = 0;
    GateTerms terms{};
    double advantage = 0;  // gain − loss, without a trial's limit on the loss
    double worth_s = 0;    // the gate passes if this is above 0
  };

  void SetPriors(std::span<const BetaPosterior> priors);
  void StartFromPriors(const RegimeFeatures& features);
  static Visit VisitOf(const ShadowSample& sample);
  void Observe(uint32_t arm, const Visit& visit);
  Increment VisitIncrement(uint32_t arm, double log_cost) const;
  RelativeCostFilter& filter() { return beliefs_.filter(); }
  const RelativeCostFilter& filter() const { return beliefs_.filter(); }
  void Assume(uint32_t arm, double log_cost);
  double IntervalsSince(int64_t earlier_ns, int64_t now_ns) const;
  void AdvanceTo(int64_t now_ns);
  void AdvanceBans(double intervals);
  void UpdatePosteriors();
  double LongestHorizonSeconds() const;
  double HorizonSeconds(int64_t now_ns, int64_t start_ns) const;
  bool LaneReports(int64_t now_ns) const;
  bool HasMeasuredCost(uint32_t arm) const;
  bool IsKnownEnough(uint32_t arm, int64_t now_ns) const;
  bool IsSafe(uint32_t arm, const ChoiceInput& input) const;
  bool IsContender(const ChoiceInput& input, uint32_t arm) const;
  bool IsTrial(const ChoiceInput& input, uint32_t arm) const;
  Assessment Assess(const ChoiceInput& input, uint32_t candidate) const;
  std::optional<Assessment> BestSwitch(const ChoiceInput& input) const;

  DecisionOptions options_;
  AdaptiveComponents components_;
  const bool stops_trials_;
  const RegimePriors regime_priors_;
  RegimeBeliefs beliefs_;
  std::vector<bool> has_prior_;
  std::vector<bool> observed_;  // arms observed in this session, live or by the lane
  std::vector<Ban> bans_;
  // Arms with a live window in this session, or with cheap_end_counts_ above 2.
  std::vector<bool> was_live_;
  // Early ends of trials whose mean search was cheaper than the active arm's.
  std::vector<uint32_t> cheap_end_counts_;
  std::vector<BetaPosterior> posteriors_;
  std::optional<int64_t> last_advance_ns_;
  std::optional<int64_t> last_shadow_ns_;
  uint64_t switch_count_ = 0;
  double switch_cost_s_ = 0;    // mean of the measured ones
  double detection_share_ = 1;  // detection's share of the frame time in the latest window
};

}  // namespace sweepstake::decision
