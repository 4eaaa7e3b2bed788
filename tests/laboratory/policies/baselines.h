// Baselines of study_policies.h that other code uses, too.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "engine_client/decider/policy/paper_policy.h"
#include "engine_client/decider/policy/posterior_update.h"
#include "engine_client/math/random.h"

namespace sweepstake::decision {

// Chooses an arm at random once per cooldown (`random`), to measure what choices without any
// knowledge cost. All arms, including the active one, have the same probability. The learnt rewards
// are not used.
class RandomPolicy : public RewardPolicy {
 public:
  explicit RandomPolicy(const PolicySetup& setup)
      : RewardPolicy(setup), cooldown_ns_(setup.options.cooldown_ns) {}

  Choice Choose(const ChoiceInput& input) const override {
    if (!IsTimeToChoose(input, cooldown_ns_)) return ChoiceOf(input.active_arm);
    const auto arm_count = static_cast<uint32_t>(posteriors().size());
    RandomStream stream(input.seed, RandomPurpose::kChoice, input.decision_id, 0);
    Choice choice = ChoiceOf(stream.NextBelow(arm_count));
    choice.propensity = 1.0 / arm_count;
    return choice;
  }

 private:
  int64_t cooldown_ns_;
};

// Thompson sampling that forgets (`discounted-ts`; V. Raj, S. Kalyani, "Taming non-stationary
// bandits: a Bayesian approach", arXiv:1707.09727, 2017). At the end of every window the evidence
// of ALL arms is multiplied by γ, then the new window is added to the active arm. The posteriors of
// arms without recent windows thus become nearly flat again.
//
// γ = 0.99 per window of 2 s is a memory of 100 windows, five cooldowns. A shorter memory would
// forget an arm before it can be chosen again. Loaded priors are forgotten like evidence, down to
// Beta(1,1). The increments that are stored are not discounted, because each policy that reads them
// has its own rule for forgetting.
class DiscountedPolicy : public ThompsonPolicy {
 public:
  static constexpr double kDiscount = 0.99;

  explicit DiscountedPolicy(const PolicySetup& setup)
      : ThompsonPolicy(setup), discounted_(setup.priors) {}

  std::optional<WindowUpdate> LearnWindow(const WindowObservation& observation) override {
    const std::optional<WindowUpdate> update = ThompsonPolicy::LearnWindow(observation);
    if (!update) return update;
    for (BetaPosterior& posterior : discounted_) {
      posterior.alpha = 1 + kDiscount * (posterior.alpha - 1);
      posterior.beta = 1 + kDiscount * (posterior.beta - 1);
    }
    Apply(update->increment, discounted_);
    return update;
  }
  Increment LearnBailOut(uint32_t arm) override {
    const Increment increment = ThompsonPolicy::LearnBailOut(arm);
    Apply(increment, discounted_);
    return increment;
  }
  const std::vector<BetaPosterior>& posteriors() const override { return discounted_; }

 private:
  std::vector<BetaPosterior> discounted_;
};

// Estimates the variance of one window's log-cost within an arm, pooled over the arms and inflated
// for the correlation of successive windows. The memory is bounded by the number of arms.
class PooledVariance {
 public:
  explicit PooledVariance(uint32_t arm_count) : arms_(arm_count) {}

  void Add(uint32_t arm, double log_cost);
  // Returns the variance of a window's log-cost. Without any windows, this is the square of an
  // assumed standard deviation of 5 %.
  double value() const;

 private:
  struct Arm {
    double count = 0;
    double mean = 0;
    double last_residual = 0;
  };

  std::vector<Arm> arms_;
  double degrees_ = 0;  // degrees of freedom
  double squares_ = 0;
  double products_ = 0;  // sum of the products of successive residuals
};

// Linear Thompson sampling on the scene's descriptor (`lin-ts`; S. Agrawal, N. Goyal, "Thompson
// sampling for contextual bandits with linear payoffs", ICML 2013; one model per arm, as in L. Li
// et al., WWW 2010). An arm's reward is xᵀθ of the scene's features x, with B = Σxxᵀ, f = Σxr and
// θ ~ N(B⁻¹f, v²B⁻¹). At every tick xᵀθ is drawn for each arm from N(xᵀB⁻¹f, v² xᵀB⁻¹x); the arm
// with the highest draw is the candidate.
//
// v = 0.1, a tenth of the reward's range. The arm's Beta prior counts as α+β observations of the
// constant feature with mean μ; the other coefficients have the unit prior of Li et al. A bail-out
// counts as several observations of reward 0, as many as its penalty. Features without a
// measurement are 0. Before the first descriptor all features except the constant are 0. Each
// choice takes one 8 × 8 Cholesky factorization per arm. The results have the same bits on every
// platform (Eigen without vectorization).
class LinTsPolicy : public RewardPolicy {
 public:
  static constexpr size_t kFeatureCount = 8;
  static constexpr double kSpread = 0.1;  // v
  using Features = std::array<double, kFeatureCount>;

  // Returns features in [0, 1], for every descriptor.
  static Features FeaturesOf(const SceneDescriptor& descriptor);

  explicit LinTsPolicy(const PolicySetup& setup);

  std::optional<WindowUpdate> LearnWindow(const WindowObservation& observation) override;
  Increment LearnBailOut(uint32_t arm) override;
  void LearnDescriptor(const SceneDescriptor& descriptor, int64_t now_ns) override;
  Choice Choose(const ChoiceInput& input) const override;

 private:
  struct Model {
    std::array<double, kFeatureCount * kFeatureCount> precision{};  // B, by columns
    Features response{};                                            // f
  };

  void Observe(const Increment& increment);
  // The distribution of an arm's expected reward in the current scene.
  struct Belief {
    double mean = 0;
    double variance = 0;  // the variance divided by v²
  };
  Belief BeliefOf(const Model& model) const;

  std::vector<Model> models_;  // one per arm
  Features features_;
};

}  // namespace sweepstake::decision
