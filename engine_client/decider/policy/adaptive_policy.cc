#include "engine_client/decider/policy/adaptive_policy.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine_client/decider/policy/diagnosis.h"
#include "engine_client/decider/policy/posterior_update.h"
#include "engine_client/math/difference_variances.h"
#include "engine_client/math/normal_distribution.h"
#include "engine_client/math/portable_math.h"

namespace sweepstake::decision {
namespace {

constexpr double kFlatShare = 0.2;           // share of a belief that ignores the prior
constexpr double kUnsafeDeviations = 2.326;  // the 99 % quantile of a normal distribution
constexpr double kTie = 0.005;  // smaller expected gains (log-cost) cause no switch to a known arm
constexpr uint32_t kTrialLimitPercent = 120;  // chosen: a hitch of 20 % of the search is not seen
constexpr double kBanGrowth = 4;              // chosen: the fourth ban lasts for hours

double Seconds(int64_t ns) { return static_cast<double>(ns) * 1e-9; }

double LogCostOfNs(uint64_t ns) { return LogCostOf(static_cast<double>(ns) * 1e-3); }

// Returns whether the prior knows no more than Beta(1, 1).
bool IsFlat(const BetaPosterior& prior) { return prior.evidence() <= BetaPosterior{}.evidence(); }

}  // namespace

AdaptivePolicy::AdaptivePolicy(const PolicySetup& setup, const AdaptiveComponents& components)
    : options_(setup.options),
      components_(components),
      stops_trials_(setup.stops_trials),
      regime_priors_(setup.regime_priors),
      beliefs_(RelativeCostFilter(static_cast<uint32_t>(setup.arms.size()), components.filter)),
      has_prior_(setup.arms.size(), false),
      observed_(setup.arms.size(), false),
      bans_(setup.arms.size()),
      was_live_(setup.arms.size(), false),
      cheap_end_counts_(setup.arms.size()),
      posteriors_(setup.arms.size()) {
  if (setup.has_priors) SetPriors(setup.priors);
  UpdatePosteriors();
}

// Uses the priors with enough evidence. The other arms keep their mean differences from these. They
// are as uncertain as between two regimes if they were observed, and otherwise unknown.
void AdaptivePolicy::SetPriors(std::span<const BetaPosterior> priors) {
  double shift = 0;
  double count = 0;
  for (uint32_t arm = 0; arm < priors.size(); ++arm) {
    if (IsFlat(priors[arm])) continue;
    shift += BeliefOf(priors[arm]).mean - filter().LogCost(arm).mean;
    ++count;
  }
  if (count == 0) return;
  std::vector<NormalBelief> beliefs;
  for (uint32_t arm = 0; arm < priors.size(); ++arm) {
    const bool is_known = !IsFlat(priors[arm]);
    NormalBelief belief{filter().LogCost(arm).mean + shift / count,
                        observed_[arm] ? kTransferVariance : kUnknownVariance};
    if (is_known) belief = BeliefOf(priors[arm]);
    has_prior_[arm] = has_prior_[arm] || is_known;
    belief.variance = std::max(belief.variance, kTransferVariance);
    beliefs.push_back(belief);
  }
  filter().ForgetCosts();
  for (uint32_t arm = 0; arm < beliefs.size(); ++arm) filter().SetPrior(arm, beliefs[arm]);
}

AdaptivePolicy::Visit AdaptivePolicy::VisitOf(const ShadowSample& sample) {
  return {.sweep = sample.first_frame_index,
          .log_cost = LogCostOfNs(sample.detection_time_ns),
          .is_bound = (sample.flags & kShadowCapped) != 0};
}

// Starts the present regime, which is new, from the priors of the most similar regime. Keeps the
// beliefs if no regime with priors is similar. A bail-out counts in every regime.
void AdaptivePolicy::StartFromPriors(const RegimeFeatures& features) {
  const std::optional<size_t> nearest = NearestOf(regime_priors_.buckets, features, /*limit=*/1);
  if (!nearest) return;
  SetPriors(regime_priors_.Of(*nearest));
  for (uint32_t arm = 0; arm < bans_.size(); ++arm) {
    if (bans_[arm].intervals_left > 0)
      filter().Assume(arm, LogCostOfNs(static_cast<uint64_t>(options_.bail_out_ns)));
  }
}

void AdaptivePolicy::Observe(uint32_t arm, const Visit& visit) {
  if (visit.is_bound) return filter().ObserveShadowBound(arm, visit.sweep, visit.log_cost);
  filter().ObserveShadow(arm, visit.sweep, visit.log_cost);
}

// Returns the evidence to store for a visit. The visit's log-cost is corrected by the lane's
// estimated bias: the bias of this arm if it was live, otherwise the mean bias of the arms that
// were live. For an arm that was never live the filter derives the bias from earlier beliefs, so
// correcting by it would count those beliefs twice.
Increment AdaptivePolicy::VisitIncrement(uint32_t arm, double log_cost) const {
  double bias = 0;
  double count = 0;
  for (uint32_t other = 0; other < filter().arm_count(); ++other) {
    if (!was_live_[other] || (was_live_[arm] && other != arm)) continue;
    bias += filter().LaneBias(other);
    ++count;
  }
  if (count > 0) log_cost -= bias / count;
  return LogCostIncrement(arm, RewardOf(log_cost), filter().shadow_noise());
}

DescriptorMatch AdaptivePolicy::Match(const SceneDescriptor& descriptor) const {
  return components_.regimes ? beliefs_.Match(descriptor) : DescriptorMatch::kPresent;
}

void AdaptivePolicy::LearnDescriptor(const SceneDescriptor& descriptor, int64_t now_ns) {
  if (!components_.regimes) return;
  AdvanceTo(now_ns);
  const bool has_changed = beliefs_.Observe(descriptor);
  const bool was_observed = std::find(observed_.begin(), observed_.end(), true) != observed_.end();
  if (beliefs_.is_new() && (has_changed || !was_observed)) StartFromPriors(FeaturesOf(descriptor));
  if (has_changed || beliefs_.is_new()) UpdatePosteriors();
}

// Returns the time in decision intervals, at most one. A longer gap is a pause, in which costs do
// not drift.
double AdaptivePolicy::IntervalsSince(int64_t earlier_ns, int64_t now_ns) const {
  const double passed_ns = static_cast<double>(now_ns) - static_cast<double>(earlier_ns);
  return std::min(passed_ns / static_cast<double>(options_.decision_interval_ns), 1.0);
}

// Sets the arm's cost in the beliefs of all regimes, because a bail-out counts in every regime.
void AdaptivePolicy::Assume(uint32_t arm, double log_cost) {
  for (RelativeCostFilter& filter : beliefs_.filters()) filter.Assume(arm, log_cost);
}

void AdaptivePolicy::AdvanceTo(int64_t now_ns) {
  if (last_advance_ns_ && now_ns > *last_advance_ns_) {
    const double advance = IntervalsSince(*last_advance_ns_, now_ns);
    for (RelativeCostFilter& filter : beliefs_.filters()) filter.Advance(advance);
    AdvanceBans(advance);
  }
  last_advance_ns_ = now_ns;
}

void AdaptivePolicy::AdvanceBans(double intervals) {
  for (uint32_t arm = 0; arm < bans_.size(); ++arm) {
    double& left = bans_[arm].intervals_left;
    if (left <= 0) continue;
    left -= intervals;
    if (left <= 0 && !last_shadow_ns_) Assume(arm, bans_[arm].log_cost);
  }
}

std::vector<Increment> AdaptivePolicy::LearnShadow(std::span<const ShadowSample> samples,
                                                   int64_t now_ns) {
  if (!components_.shadow) return {};
  std::vector<Increment> increments;
  last_shadow_ns_ = now_ns;
  AdvanceTo(now_ns);
  for (const ShadowSample& sample : samples) {
    const Visit visit = VisitOf(sample);
    if (!visit.is_bound) observed_[sample.arm] = true;
    const bool is_news = !visit.is_bound || visit.log_cost > filter().LogCost(sample.arm).mean;
    Observe(sample.arm, visit);
    if (is_news) increments.push_back(VisitIncrement(sample.arm, visit.log_cost));
  }
  UpdatePosteriors();
  return increments;
}

std::optional<WindowUpdate> AdaptivePolicy::LearnWindow(const WindowObservation& observation) {
  const WindowMetrics metrics = observation.window.Metrics();
  if (!metrics.IsFinite()) return std::nullopt;
  AdvanceTo(observation.now_ns);
  const double log_cost = LogCostOf(metrics.calm_detection_ms * 1e3);
  const bool has_one_regime = components_.regimes && beliefs_.regime_count() == 1;
  filter().ObserveLive(observation.arm, log_cost,
                       LaneReports(observation.now_ns) && has_one_regime);
  observed_[observation.arm] = true;
  was_live_[observation.arm] = true;
  detection_share_ = std::clamp(metrics.detection_ms * metrics.fps * 1e-3, 1e-4, 1.0);
  UpdatePosteriors();
  const double reward = RewardOf(log_cost);
  return WindowUpdate{.increment = LogCostIncrement(observation.arm, reward, filter().live_noise()),
                      .reward = reward};
}

double AdaptivePolicy::WindowEvidence(uint32_t arm) const {
  return EvidenceOf(posteriors_[arm].mean(), filter().live_noise());
}

// The penalty is options_.bail_out_penalty windows of reward 0, not single observations as in the
// paper. One window here counts as thousands of observations, so the paper's ten would change
// nothing in a stored prior.
Increment AdaptivePolicy::LearnBailOut(uint32_t arm) {
  const double window_evidence = WindowEvidence(arm);
  Ban& ban = bans_[arm];
  if (ban.intervals_left <= 0) ban.log_cost = filter().LogCost(arm).mean;
  ban.intervals_left = ban.next_intervals;
  ban.next_intervals *= kBanGrowth;
  Assume(arm, LogCostOfNs(static_cast<uint64_t>(options_.bail_out_ns)));
  observed_[arm] = true;
  UpdatePosteriors();
  return BailOutIncrement(arm, options_.bail_out_penalty * window_evidence);
}

void AdaptivePolicy::LearnSwitchCost(uint32_t /*arm*/, const SwitchCost& cost) {
  const double cost_s = static_cast<double>(TotalNs(cost)) * 1e-9;
  const double max_s = Seconds(options_.settling_ns) + Seconds(options_.decision_interval_ns);
  ++switch_count_;
  switch_cost_s_ += (std::min(cost_s, max_s) - switch_cost_s_) / static_cast<double>(switch_count_);
}

// Learns that the arm is at least as expensive as the mean of its trial. If that is below the cost
// of the arm before, only single searches took too long, for example rebuilds of the structure. The
// third such end was the arm's last trial.
void AdaptivePolicy::LearnTrialEnd(const TrialEnd& end, uint32_t arm_before, int64_t now_ns) {
  AdvanceTo(now_ns);
  const double log_cost = LogCostOfNs(end.detection_time_ns);
  filter().ObserveBound(end.arm, log_cost);
  observed_[end.arm] = true;
  if (log_cost < filter().LiveCost(arm_before).mean && ++cheap_end_counts_[end.arm] > 2)
    was_live_[end.arm] = true;
  UpdatePosteriors();
}

std::optional<int64_t> AdaptivePolicy::cooldown_ns() const {
  if (!components_.short_cooldown) return std::nullopt;
  return std::min(options_.settling_ns + options_.decision_interval_ns, options_.cooldown_ns);
}

// Returns the cooldown of the options. A cooldown shorter than settling plus one window counts as
// that long.
double AdaptivePolicy::LongestHorizonSeconds() const {
  const int64_t shortest_ns = options_.settling_ns + options_.decision_interval_ns;
  return Seconds(std::max(options_.cooldown_ns, shortest_ns));
}

// Returns the time over which the gate sums up the gain of a switch: the mean length of the scene's
// regimes so far. The present regime counts as one that lasts for another longest horizon.
double AdaptivePolicy::HorizonSeconds(int64_t now_ns, int64_t start_ns) const {
  const double longest_s = LongestHorizonSeconds();
  const double passed_s = std::max(Seconds(now_ns) - Seconds(start_ns), 0.0);
  const auto regimes = static_cast<double>(beliefs_.change_count() + 1);
  return (longest_s + passed_s) / regimes;
}

bool AdaptivePolicy::LaneReports(int64_t now_ns) const {
  return last_shadow_ns_ && Seconds(now_ns) - Seconds(*last_shadow_ns_) <= LongestHorizonSeconds();
}

// Returns whether enough is known about the arm to choose it: it was observed, or the lane does not
// report. The lane reports from its first visit on, until none has arrived for the longest horizon.
bool AdaptivePolicy::IsKnownEnough(uint32_t arm, int64_t now_ns) const {
  return observed_[arm] || !LaneReports(now_ns);
}

// Returns whether the arm stays below the limit of a bail-out with a probability of 99 %. An arm
// that was never seen, in a game without a lane, also counts as safe if its expected cost is not
// above the active arm's. Otherwise its wide belief alone would keep the game on a slow arm for
// ever.
bool AdaptivePolicy::IsSafe(uint32_t arm, const ChoiceInput& input) const {
  const NormalBelief cost = filter().LiveCost(arm);
  const bool unseen = !observed_[arm] && !LaneReports(input.now_ns);
  if (unseen && cost.mean <= filter().LiveCost(input.active_arm).mean) return true;
  const double limit = LogCostOfNs(static_cast<uint64_t>(options_.bail_out_ns));
  return cost.mean + kUnsafeDeviations * std::sqrt(cost.variance) < limit;
}

// Returns whether a switch to the arm would be a trial: the arm was not live yet, and no bail-out
// demands the switch. Without a settling time, and with a client that does not stop them, there are
// no trials.
bool AdaptivePolicy::IsTrial(const ChoiceInput& input, uint32_t arm) const {
  return stops_trials_ && !was_live_[arm] && !input.bailed_out && options_.settling_ns > 0;
}

// Looks one step ahead: the candidate runs for the cooldown, its windows show its cost, and the
// policy then keeps it or returns. E⁺ and E⁻ are the expected gain and loss under the belief about
// the mean difference after the next window (P. Frazier, W. Powell, S. Dayanik, "A
// knowledge-gradient policy for sequential information collection", SIAM J. Control Optim. 47,
// 2008). They differ from the present mean only as far as there is something to learn.
AdaptivePolicy::Assessment AdaptivePolicy::Assess(const ChoiceInput& input,
                                                  uint32_t candidate) const {
  const double mean = filter().Difference(input.active_arm, candidate).mean;
  const double deviation = std::sqrt(filter().ResolvedVariance(input.active_arm, candidate));
  Assessment result{.arm = candidate};
  GateTerms& terms = result.terms;
  terms.gain = ExpectedGain(mean, deviation);
  double loss = ExpectedGain(-mean, deviation);
  terms.horizon_s = HorizonSeconds(input.now_ns, input.start_ns);
  if (!observed_[candidate]) {
    // Mix the belief with a flat one that ignores the prior, because the arm was not observed.
    const double flat = ExpectedGain(0, std::sqrt(kUnknownVariance));
    const double share = has_prior_[candidate] ? kFlatShare : 1;
    terms.gain += share * (flat - terms.gain);
    loss += share * (flat - loss);
  }
  terms.cooldown_s = Seconds(cooldown_ns().value_or(options_.cooldown_ns));
  terms.cost_s = switch_cost_s_ / detection_share_;
  result.advantage = terms.gain - loss;
  terms.loss =
      math::Exp(loss) - 1;  // an arm that is 100 times as expensive loses 99 times the cost
  if (observed_[candidate] && IsTrial(input, candidate)) {
    terms.loss = std::min(terms.loss, kTrialBudget / detection_share_);
  }
  result.worth_s = terms.horizon_s * terms.gain - terms.cooldown_s * terms.loss - terms.cost_s;
  if (terms.gain < kTie && !IsTrial(input, candidate))
    result.worth_s = std::min(result.worth_s, 0.0);
  if (!components_.gate) result.worth_s = result.advantage;
  return result;
}

// Returns whether to consider switching to the arm. With a lane, an arm that was live is considered
// only if it is believed to be cheaper, because the lane measures it anyway. The first live window
// of another arm would show the lane's bias for it.
bool AdaptivePolicy::IsContender(const ChoiceInput& input, uint32_t arm) const {
  return !was_live_[arm] || !LaneReports(input.now_ns) ||
         filter().Difference(input.active_arm, arm).mean > 0;
}

std::optional<AdaptivePolicy::Assessment> AdaptivePolicy::BestSwitch(
    const ChoiceInput& input) const {
  std::optional<Assessment> best;
  for (uint32_t arm = 0; arm < filter().arm_count(); ++arm) {
    if (arm == input.active_arm) continue;
    if (!input.bailed_out && (!IsKnownEnough(arm, input.now_ns) || !IsSafe(arm, input))) continue;
    if (!IsContender(input, arm)) continue;
    const Assessment assessment = Assess(input, arm);
    if (!best || assessment.worth_s > best->worth_s) best = assessment;
  }
  return best;
}

Choice AdaptivePolicy::Choose(const ChoiceInput& input) const {
  Choice choice;
  choice.candidate = input.active_arm;
  const std::optional<Assessment> best = BestSwitch(input);
  if (!best) return choice;
  choice.gate = best->terms;
  const bool better = best->advantage > 0;
  const bool worthwhile = best->worth_s > 0;
  // Report the best candidate even if it does not pass the gate, as long as it is believed to be
  // cheaper.
  if (worthwhile || better) choice.candidate = best->arm;
  if (IsTrial(input, choice.candidate)) choice.trial_limit_percent = kTrialLimitPercent;
  if (!worthwhile) choice.hold = DecisionOutcome::kHeldGate;
  return choice;
}

Diagnosis AdaptivePolicy::Diagnose() const {
  std::vector<double> means;
  std::vector<double> covariance;
  bool has_cost = false;
  for (uint32_t a = 0; a < filter().arm_count(); ++a) {
    has_cost = has_cost || HasMeasuredCost(a);
    means.push_back(filter().LogCost(a).mean);
    for (uint32_t b = 0; b < filter().arm_count(); ++b)
      covariance.push_back(filter().Covariance(a, b));
  }
  if (!has_cost) return {};
  return DiagnoseCorrelatedLogCosts(means, covariance);
}

// Returns whether the belief about the arm's cost comes from measurements of this session or from a
// prior. The cost of a banned arm is assumed.
bool AdaptivePolicy::HasMeasuredCost(uint32_t arm) const {
  return (observed_[arm] || has_prior_[arm]) && bans_[arm].intervals_left <= 0;
}

RegimeFeatures AdaptivePolicy::present_features() const {
  return beliefs_.memory().FeaturesAt(beliefs_.present_place());
}

RegimeId AdaptivePolicy::present_regime() const {
  return beliefs_.memory().IdAt(beliefs_.present_place());
}

std::optional<double> AdaptivePolicy::ExpectedLogCost(uint32_t arm) const {
  if (!HasMeasuredCost(arm)) return std::nullopt;
  return filter().LogCost(arm).mean;
}

std::vector<RegimeBelief> AdaptivePolicy::Regimes() const {
  std::vector<RegimeBelief> regimes;
  for (uint32_t place = 0; place < beliefs_.regime_count(); ++place) {
    const RelativeCostFilter& costs = beliefs_.filter_at(place);
    RegimeBelief regime = {.id = beliefs_.memory().IdAt(place),
                           .centre = beliefs_.memory().CentreAt(place),
                           .is_present = place == beliefs_.present_place()};
    std::vector<double> means, covariance;
    for (uint32_t a = 0; a < costs.arm_count(); ++a) {
      regime.arms.push_back({.log_cost = costs.LogCost(a), .is_known = HasMeasuredCost(a)});
      means.push_back(costs.LogCost(a).mean);
      for (uint32_t b = 0; b < costs.arm_count(); ++b) covariance.push_back(costs.Covariance(a, b));
    }
    const std::vector<double> variances = IndependentVariancesLike(means, covariance);
    for (uint32_t arm = 0; arm < variances.size(); ++arm)
      regime.arms[arm].difference_variance = variances[arm];
    regimes.push_back(std::move(regime));
  }
  return regimes;
}

// Converts the beliefs into one Beta posterior per arm, for the log and for watchers. The
// posteriors count as independent, but beliefs are correlated. The variances are therefore chosen
// such that the difference between each arm and the leader has the filter's variance.
void AdaptivePolicy::UpdatePosteriors() {
  uint32_t leader = 0;
  for (uint32_t arm = 1; arm < filter().arm_count(); ++arm) {
    if (filter().LogCost(arm).mean < filter().LogCost(leader).mean) leader = arm;
  }
  // The leader gets half of the smallest variance of a difference, and every other arm gets the
  // rest of its own difference's variance.
  double smallest = kUnknownVariance;
  for (uint32_t arm = 0; arm < filter().arm_count(); ++arm) {
    if (arm != leader) smallest = std::min(smallest, filter().Difference(arm, leader).variance);
  }
  for (uint32_t arm = 0; arm < filter().arm_count(); ++arm) {
    const double variance =
        arm == leader ? smallest / 2 : filter().Difference(arm, leader).variance - smallest / 2;
    posteriors_[arm] = BetaOf({filter().LogCost(arm).mean, variance});
  }
}

}  // namespace sweepstake::decision
