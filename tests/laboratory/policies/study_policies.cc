#include "tests/laboratory/policies/study_policies.h"

#include <algorithm>
#include <array>
#include <cmath>  // std::sqrt, exactly rounded by IEEE 754
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine_client/decider/policy/adaptive_policy.h"
#include "engine_client/decider/policy/log_cost.h"
#include "engine_client/math/portable_math.h"
#include "tests/laboratory/policies/baselines.h"

namespace sweepstake::decision {
namespace {

// UCB1 (P. Auer, N. Cesa-Bianchi, P. Fischer, "Finite-time analysis of the multiarmed bandit
// problem", Machine Learning 47, 2002) chooses the arm with the highest
//
//   x̄ + √(2 ln n / nₐ),
//
// where x̄ is an arm's mean reward, nₐ the number of its windows and n the number of windows of all
// arms. Mean and count are the posterior's μ and α+β, so that loaded priors and bail-outs count as
// evidence; the flat prior counts as two windows of reward ½. There are no random draws. It chooses
// at every tick, and only the cooldown delays its switches. The bounds are recorded in place of
// draws.
class Ucb1Policy : public RewardPolicy {
 public:
  using RewardPolicy::RewardPolicy;

  Choice Choose(const ChoiceInput& /*input*/) const override {
    constexpr double kMinEvidence = 1e-6;  // keeps a bound finite for all priors
    double window_count = 0;
    for (const BetaPosterior& posterior : posteriors()) window_count += posterior.evidence();
    const double log_count = math::Log(std::max(window_count, 1.0));
    std::vector<double> bounds;
    for (const BetaPosterior& posterior : posteriors()) {
      bounds.push_back(posterior.mean() +
                       std::sqrt(2 * log_count / std::max(posterior.evidence(), kMinEvidence)));
    }
    return HighestOf(std::move(bounds));
  }
};

// ε-greedy (R. Sutton, A. Barto, "Reinforcement Learning", 2nd ed., §2.4) chooses the arm with the
// highest mean reward. With probability ε it chooses any arm with equal probability instead. The
// mean rewards are recorded in place of draws.
//
// ε = 0.1, the book's usual value, is constant: a decaying ε would finish its exploration within
// the first few of the 22 choices in a run of 15 minutes. It chooses once per cooldown. If it chose
// at each tick of 2 s, it would leave the arm with a probability of 88 % within 20 ticks.
class EpsilonGreedyPolicy : public RewardPolicy {
 public:
  explicit EpsilonGreedyPolicy(const PolicySetup& setup)
      : RewardPolicy(setup), cooldown_ns_(setup.options.cooldown_ns) {}

  Choice Choose(const ChoiceInput& input) const override {
    constexpr double kEpsilon = 0.1;
    if (!IsTimeToChoose(input, cooldown_ns_)) return ChoiceOf(input.active_arm);
    std::vector<double> means;
    for (const BetaPosterior& posterior : posteriors()) means.push_back(posterior.mean());
    const auto arm_count = static_cast<uint32_t>(means.size());
    Choice choice = HighestOf(std::move(means));
    const uint32_t greedy = choice.candidate;
    RandomStream stream(input.seed, RandomPurpose::kChoice, input.decision_id, 0);
    if (stream.NextUniform() < kEpsilon) choice.candidate = stream.NextBelow(arm_count);
    choice.propensity = kEpsilon / arm_count + (choice.candidate == greedy ? 1 - kEpsilon : 0);
    return choice;
  }

 private:
  int64_t cooldown_ns_;
};

// The rule that a game developer would write by hand (`thresholds`), from the scene's object count
// and density, with arms by name:
//
//   fewer than 128 objects              BruteForce
//   up to 2,500, density up to 0.5      AxisSweep, else SAP
//   otherwise                           KDTree, else DBVT
//
// The reasons: testing all pairs of a hundred boxes costs less than maintaining any structure.
// Sweeping one axis makes about 2 n^(2/3) ρ^(1/3) checks per object (n objects in a cube of density
// ρ), so it is cheap only while n and ρ are small. The paper found the sweep ahead up to 2,000
// objects, and the tree ahead at 3,000 and in crowded scenes (Table 3, §7). The authors of the
// KD-tree found the same (Y. Serpa, M. Rodrigues, CGF 38, 2019). At a density of ½ every object
// touches others wherever it is. The numbers were chosen before any recorded scene was examined and
// are not tuned to any scene.
//
// If the first arm of a row is not available, the second one is chosen.
std::vector<std::string_view> HandWrittenRule(const SceneDescriptor& scene) {
  if (!IsMeasured(scene.object_count)) return {};
  if (scene.object_count < 128) return {"BruteForce"};
  const bool sparse = scene.object_count <= 2'500 && scene.density_ratio <= 0.5F;
  if (sparse) return {"AxisSweep", "SAP"};
  return {"KDTree", "DBVT"};
}

// The same kind of rule, fitted to the traces of the tuning list (`thresholds-fitted`):
//
//   motion per frame below 0.00088,
//     or not measured, which is −1      KDTree, else SAP
//   motion below 0.0072                 DBVT, else Tracy
//   46 % of the objects rest, or more   SAP, else Grid
//   otherwise                           KDTree, else DBVT
//
// tests/bench/fit_thresholds.py printed it for the 13 traces of tests/bench/data/tuning_scenes.txt
// (240 to 1,200 frames, release program, AMD EPYC with AVX-512). There the named arm costs 1.4 %
// more than the fastest one on average, and the best single arm 12.4 %. Motion is in world units,
// so the rule suits scenes of the list's scale, as a rule in a game suits that game.
std::vector<std::string_view> FittedRule(const SceneDescriptor& scene) {
  if (!IsMeasured(scene.object_count)) return {};
  if (scene.speed_mean < 0.00088F) return {"KDTree", "SAP"};
  if (scene.speed_mean < 0.0072F) return {"DBVT", "Tracy"};
  if (scene.static_ratio >= 0.46F) return {"SAP", "Grid"};
  return {"KDTree", "DBVT"};
}

// Chooses the first available arm that a rule names for the latest descriptor. The active arm stays
// if none is available, or if the rule names none. An arm that has bailed out is not chosen again.
// The learnt rewards are not used.
class RulePolicy : public RewardPolicy {
 public:
  using Rule = std::vector<std::string_view> (*)(const SceneDescriptor& scene);

  RulePolicy(const PolicySetup& setup, Rule rule)
      : RewardPolicy(setup), rule_(rule), arms_(setup.arms), bailed_out_(setup.arms.size()) {}

  Increment LearnBailOut(uint32_t arm) override {
    bailed_out_[arm] = true;
    return RewardPolicy::LearnBailOut(arm);
  }
  void LearnDescriptor(const SceneDescriptor& descriptor, int64_t /*now_ns*/) override {
    scene_ = descriptor;
  }
  Choice Choose(const ChoiceInput& input) const override {
    for (const std::string_view name : rule_(scene_)) {
      const auto found = std::find(arms_.begin(), arms_.end(), name);
      const auto arm = static_cast<uint32_t>(found - arms_.begin());
      if (found != arms_.end() && !bailed_out_[arm]) return ChoiceOf(arm);
    }
    return ChoiceOf(input.active_arm);
  }

 private:
  Rule rule_;
  std::vector<std::string> arms_;
  std::vector<bool> bailed_out_;
  SceneDescriptor scene_;  // the latest one
};

class ThresholdsPolicy : public RulePolicy {
 public:
  explicit ThresholdsPolicy(const PolicySetup& setup) : RulePolicy(setup, HandWrittenRule) {}
};

// Returns the cooldown of a policy whose choices do not depend on live windows: the settling time
// plus one window.
int64_t ShortCooldown(const DecisionOptions& options) {
  return std::min(options.cooldown_ns, options.settling_ns + options.decision_interval_ns);
}

class FittedThresholdsPolicy : public RulePolicy {
 public:
  explicit FittedThresholdsPolicy(const PolicySetup& setup)
      : RulePolicy(setup, FittedRule), cooldown_ns_(ShortCooldown(setup.options)) {}

  std::optional<int64_t> cooldown_ns() const override { return cooldown_ns_; }

 private:
  int64_t cooldown_ns_;
};

// Runs the arm that is cheapest in the shadow lane (`lane-argmin`). This trivial policy is the
// baseline for all policies that learn from the lane.
//
// Each arm has a smoothed log-cost of its visits. The cheapest arm is chosen if it is cheaper than
// the active arm by kMargin. The cooldown is the settling time plus one window. The learnt rewards
// are not used, but an arm that has bailed out is not chosen again.
class LaneArgminPolicy : public RewardPolicy {
 public:
  explicit LaneArgminPolicy(const PolicySetup& setup)
      : RewardPolicy(setup),
        cooldown_ns_(ShortCooldown(setup.options)),
        log_costs_(setup.arms.size(), kUnseen),
        bailed_out_(setup.arms.size()) {}

  Increment LearnBailOut(uint32_t arm) override {
    bailed_out_[arm] = true;
    return RewardPolicy::LearnBailOut(arm);
  }
  std::vector<Increment> LearnShadow(std::span<const ShadowSample> samples,
                                     int64_t /*now_ns*/) override {
    constexpr double kWeight = 0.3;  // weight of a new visit in an arm's mean
    for (const ShadowSample& sample : samples) {
      const double log_cost = LogCostOf(static_cast<double>(sample.detection_time_ns) * 1e-3);
      double& mean = log_costs_[sample.arm];
      mean = mean < kUnseen ? mean + kWeight * (log_cost - mean) : log_cost;
    }
    return {};
  }
  Choice Choose(const ChoiceInput& input) const override {
    constexpr double kMargin = 0.025;  // minimum gain in log-cost for a switch
    uint32_t candidate = input.active_arm;
    double cheapest = bailed_out_[candidate] ? kUnseen : log_costs_[candidate] - kMargin;
    for (uint32_t arm = 0; arm < log_costs_.size(); ++arm) {
      if (bailed_out_[arm] || log_costs_[arm] >= cheapest) continue;
      cheapest = log_costs_[arm];
      candidate = arm;
    }
    return ChoiceOf(candidate);
  }
  std::optional<int64_t> cooldown_ns() const override { return cooldown_ns_; }

 private:
  static constexpr double kUnseen = 1e9;  // the log-cost of an arm before the lane's first visit

  int64_t cooldown_ns_;
  std::vector<double> log_costs_;
  std::vector<bool> bailed_out_;
};

// The paper's policy (`paper-one-draw`) with one draw per cooldown (IsTimeToChoose). The paper
// itself draws every 2 s until a draw chooses another arm. With one draw, an arm that is the best
// with probability 0.9 runs some 90 % of the time instead of 57 %.
class OneDrawPolicy : public ThompsonPolicy {
 public:
  explicit OneDrawPolicy(const PolicySetup& setup)
      : ThompsonPolicy(setup), cooldown_ns_(setup.options.cooldown_ns) {}

  Choice Choose(const ChoiceInput& input) const override {
    return IsTimeToChoose(input, cooldown_ns_) ? ThompsonPolicy::Choose(input)
                                               : ChoiceOf(input.active_arm);
  }

 private:
  int64_t cooldown_ns_;
};

// Thompson sampling on calibrated beliefs (`calibrated`). The reward is the absolute log-cost
// (log_cost.h), and each window counts as κ = max(1, μ(1−μ) ÷ σ̂²) observations, where σ̂² is the
// pooled variance. The paper counts each window as one observation. The penalty of a bail-out is a
// number of windows of reward 0; in the paper it is a number of observations.
class CalibratedPolicy : public ThompsonPolicy {
 public:
  explicit CalibratedPolicy(const PolicySetup& setup)
      : ThompsonPolicy(setup),
        bail_out_penalty_(setup.options.bail_out_penalty),
        variance_(static_cast<uint32_t>(setup.arms.size())),
        posteriors_(setup.priors) {}

  std::optional<WindowUpdate> LearnWindow(const WindowObservation& observation) override {
    const WindowMetrics metrics = observation.window.Metrics();
    if (!metrics.IsFinite()) return std::nullopt;
    const double log_cost = LogCostOf(metrics.detection_ms * 1e3);
    variance_.Add(observation.arm, log_cost);
    const double reward = RewardOf(log_cost);
    const Increment increment = LogCostIncrement(observation.arm, reward, variance_.value());
    Apply(increment, posteriors_);
    return WindowUpdate{.increment = increment, .reward = reward};
  }
  Increment LearnBailOut(uint32_t arm) override {
    const Increment increment = BailOutIncrement(arm, bail_out_penalty_ * WindowEvidence(arm));
    Apply(increment, posteriors_);
    return increment;
  }
  const std::vector<BetaPosterior>& posteriors() const override { return posteriors_; }
  double WindowEvidence(uint32_t arm) const override {
    return EvidenceOf(posteriors_[arm].mean(), variance_.value());
  }

 private:
  double bail_out_penalty_;
  PooledVariance variance_;
  std::vector<BetaPosterior> posteriors_;
};

template <typename Kind>
std::unique_ptr<Policy> Make(const PolicySetup& setup) {
  return std::make_unique<Kind>(setup);
}

constexpr std::array kBaselines = {
    PolicyEntry{{.name = "paper-one-draw", .draws_from_posteriors = true}, Make<OneDrawPolicy>},
    PolicyEntry{{.name = "random", .explores = false}, Make<RandomPolicy>},
    PolicyEntry{{.name = "thresholds", .explores = false}, Make<ThresholdsPolicy>},
    PolicyEntry{{.name = "thresholds-fitted", .explores = false}, Make<FittedThresholdsPolicy>},
    PolicyEntry{{.name = "ucb1"}, Make<Ucb1Policy>},
    PolicyEntry{{.name = "epsilon-greedy"}, Make<EpsilonGreedyPolicy>},
    PolicyEntry{{.name = "discounted-ts", .draws_from_posteriors = true}, Make<DiscountedPolicy>},
    PolicyEntry{{.name = "lin-ts"}, Make<LinTsPolicy>},
    PolicyEntry{{.name = "lane-argmin", .explores = false, .uses_shadow = true},
                Make<LaneArgminPolicy>},
    PolicyEntry{{.name = "calibrated",
                 .reward_version = kLogCostRewardVersion,
                 .draws_from_posteriors = true},
                Make<CalibratedPolicy>},
};

template <AdaptiveComponents kComponents>
constexpr PolicyEntry AdaptiveWith(std::string_view name) {
  PolicyKind kind = AdaptivePolicy::kKind;
  kind.name = name;
  kind.uses_shadow = kComponents.shadow;
  return {kind, [](const PolicySetup& setup) -> std::unique_ptr<Policy> {
            return std::make_unique<AdaptivePolicy>(setup, kComponents);
          }};
}

constexpr std::array kAblations = {
    AdaptiveWith<AdaptiveComponents{.shadow = false}>("adaptive-without-shadow"),
    AdaptiveWith<AdaptiveComponents{.filter = {.calibration = false}}>(
        "adaptive-without-calibration"),
    AdaptiveWith<AdaptiveComponents{.filter = {.heavy_tails = false}}>(
        "adaptive-without-heavy-tails"),
    AdaptiveWith<AdaptiveComponents{.filter = {.common_mode = false}}>(
        "adaptive-without-common-mode"),
    AdaptiveWith<AdaptiveComponents{.gate = false}>("adaptive-without-gate"),
    AdaptiveWith<AdaptiveComponents{.short_cooldown = false}>("adaptive-without-short-cooldown"),
    AdaptiveWith<AdaptiveComponents{.regimes = false}>("adaptive-without-regimes"),
};

std::vector<PolicyEntry> Joined(PolicyRegistry first, PolicyRegistry second) {
  std::vector<PolicyEntry> all(first.begin(), first.end());
  all.insert(all.end(), second.begin(), second.end());
  return all;
}

}  // namespace

void PooledVariance::Add(uint32_t index, double log_cost) {
  Arm& arm = arms_[index];
  arm.count += 1;
  const double residual = log_cost - arm.mean;
  arm.mean += residual / arm.count;
  if (arm.count > 1) {
    degrees_ += 1;
    squares_ += residual * (log_cost - arm.mean);
    products_ += residual * arm.last_residual;
  }
  arm.last_residual = log_cost - arm.mean;
}

double PooledVariance::value() const {
  constexpr double kFirstVariance = 0.05 * 0.05;  // the first guess of a log-cost's variance
  constexpr double kFirstDegrees = 4;  // the first guess weighs as much as this many windows
  constexpr double kMinVariance = 0.002 * 0.002;
  constexpr double kMaxCorrelation = 0.8;
  const double squares = squares_ + kFirstDegrees * kFirstVariance;
  const double variance = squares / (degrees_ + kFirstDegrees);
  const double correlation = std::clamp(products_ / squares, 0.0, kMaxCorrelation);
  return std::max(variance * (1 + correlation) / (1 - correlation), kMinVariance);
}

PolicyRegistry ComparedPolicies() {
  static const std::vector<PolicyEntry> policies = Joined(ShippedPolicies(), kBaselines);
  return policies;
}

PolicyRegistry StudyPolicies() {
  static const std::vector<PolicyEntry> policies = Joined(ComparedPolicies(), kAblations);
  return policies;
}

}  // namespace sweepstake::decision
