// Baselines that learn by the paper's reward and choose in some other way than Thompson sampling:
// at random, by UCB1, ε-greedily, by hand-written thresholds, or by the shadow lane alone.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine_client/decider/policy/paper_policy.h"

namespace sweepstake::decision {

// Chooses any arm with equal probability, once per cooldown (`random`), to measure what choosing
// without any knowledge costs. The active arm is one of them. The learnt rewards are not used.
class RandomPolicy : public RewardPolicy {
 public:
  explicit RandomPolicy(const PolicySetup& setup)
      : RewardPolicy(setup), cooldown_ns_(setup.options.cooldown_ns) {}

  Choice Choose(const ChoiceInput& input) const override;

 private:
  int64_t cooldown_ns_;
};

// UCB1 (P. Auer, N. Cesa-Bianchi, P. Fischer, "Finite-time analysis of the multiarmed bandit
// problem", Machine Learning 47, 2002) chooses the arm with the highest
//
//   x̄ + √(2 ln n / nₐ),
//
// where x̄ is an arm's mean reward, nₐ the number of its windows and n that of all arms. Mean and
// count are the posterior's μ and α+β, so that loaded priors and bail-outs count as evidence; the
// flat prior counts as two windows of reward ½. Nothing is random. It chooses at every tick, and
// only the cooldown delays its switches.
class Ucb1Policy : public RewardPolicy {
 public:
  using RewardPolicy::RewardPolicy;
  // The draws are the bounds; among equal bounds the first arm is chosen.
  Choice Choose(const ChoiceInput& input) const override;
};

// ε-greedy (R. Sutton, A. Barto, "Reinforcement Learning", 2nd ed., §2.4) chooses the arm with the
// highest mean reward, but with probability ε any arm with equal probability.
//
// ε = 0.1, the book's usual value, is constant: a decaying ε would finish its exploration within
// the first few of the 22 choices in a run of 15 minutes. It chooses once per cooldown, because
// exploring with ε = 0.1 at each tick of 2 s would leave the arm with probability 88 % within 20
// ticks.
class EpsilonGreedyPolicy : public RewardPolicy {
 public:
  static constexpr double kEpsilon = 0.1;

  explicit EpsilonGreedyPolicy(const PolicySetup& setup)
      : RewardPolicy(setup), cooldown_ns_(setup.options.cooldown_ns) {}

  // The draws are the means; among equal means the first arm is the greedy one.
  Choice Choose(const ChoiceInput& input) const override;

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
// Sweeping one axis makes some 2 n^(2/3) ρ^(1/3) checks per object (n objects in a cube, ρ the
// density), so that it pays until n or ρ grows. The paper found it ahead up to 2,000 objects, and
// the tree ahead at 3,000 and in crowded scenes (Table 3, §7), as did the authors of the KD-tree
// (Y. Serpa, M. Rodrigues, CGF 38, 2019). At a density of ½ objects touch wherever they are. The
// numbers were written down before any recorded scene was looked at and are not tuned to any.
//
// If the first arm of a row is missing, the second is chosen; if both are, or before the first
// descriptor, the active arm stays. An arm that bailed out is not chosen again. The learnt rewards
// are not used.
class ThresholdsPolicy : public RewardPolicy {
 public:
  static constexpr double kFewObjects = 128;
  static constexpr double kManyObjects = 2'500;
  static constexpr double kDense = 0.5;

  explicit ThresholdsPolicy(const PolicySetup& setup)
      : RewardPolicy(setup), arms_(setup.arms), bailed_out_(setup.arms.size()) {}

  Increment LearnBailOut(uint32_t arm) override;
  void LearnDescriptor(const SceneDescriptor& descriptor, int64_t now_ns) override;
  Choice Choose(const ChoiceInput& input) const override;

 private:
  std::optional<uint32_t> Find(std::string_view name) const;

  std::vector<std::string> arms_;
  std::vector<bool> bailed_out_;
  std::optional<double> object_count_;
  double density_ratio_ = 0;  // the scene counts as sparse until one is measured
};

// Runs the arm that is cheapest in the shadow lane (`lane-argmin`). This trivial policy is the
// baseline for all policies that learn from the lane.
//
// Each arm has a smoothed log-cost of its visits, and the cheapest one is chosen if it is cheaper
// than the active arm by a small margin; the cooldown is settling and one window. The learnt
// rewards are not used, but an arm that bailed out is not chosen again.
class LaneArgminPolicy : public RewardPolicy {
 public:
  static constexpr PolicyKind kKind = {
      .name = "lane-argmin", .explores = false, .uses_shadow = true};
  static constexpr double kWeight = 0.3;    // of a new visit in an arm's mean
  static constexpr double kMargin = 0.025;  // of log-cost

  explicit LaneArgminPolicy(const PolicySetup& setup);

  Increment LearnBailOut(uint32_t arm) override;
  std::vector<Increment> LearnShadow(std::span<const ShadowSample> samples,
                                     int64_t now_ns) override;
  Choice Choose(const ChoiceInput& input) const override;
  std::optional<int64_t> cooldown_ns() const override { return cooldown_ns_; }

 private:
  int64_t cooldown_ns_;
  std::vector<double> log_costs_;
  std::vector<bool> bailed_out_;
};

}  // namespace sweepstake::decision
