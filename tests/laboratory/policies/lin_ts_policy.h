// Linear Thompson sampling on the scene's descriptor (`lin-ts`; S. Agrawal, N. Goyal, "Thompson
// sampling for contextual bandits with linear payoffs", ICML 2013; one model per arm, as in L. Li
// et al., WWW 2010). An arm's reward is xᵀθ of the scene's features x, with B = Σxxᵀ, f = Σxr and
// θ ~ N(B⁻¹f, v²B⁻¹). At every tick xᵀθ is drawn for each arm from N(xᵀB⁻¹f, v² xᵀB⁻¹x); the arm
// with the highest draw is the candidate.
//
// v = 0.1, a tenth of the reward's range. The arm's Beta prior counts as α+β observations of the
// constant feature with mean μ; the other coefficients have the unit prior of that paper. A
// bail-out counts as its penalty's number of observations of reward 0. Features without a
// measurement are 0. Before the first descriptor all features except the constant are 0. Each
// choice takes one 8 × 8 Cholesky factorization per arm. The results have the same bits on every
// platform (Eigen without vectorization).
#pragma once

#include <array>
#include <vector>

#include "engine_client/decider/policy/paper_policy.h"

namespace sweepstake::decision {

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
  // The belief about an arm's reward in the current scene.
  struct Belief {
    double mean = 0;
    double variance = 0;  // variance without the factor v²
  };
  Belief BeliefOf(const Model& model) const;

  std::vector<Model> models_;  // has one per arm
  Features features_;
};

}  // namespace sweepstake::decision
