#include "tests/laboratory/policies/baselines.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>  // std::sqrt, exactly rounded by IEEE 754
#include <utility>

#include "engine_client/decider/policy/diagnosis.h"
#include "engine_client/math/portable_math.h"
#include "engine_client/math/random.h"

namespace sweepstake::decision {
namespace {

constexpr int kSize = LinTsPolicy::kFeatureCount;
using Vector = Eigen::Matrix<double, kSize, 1>;
using Matrix = Eigen::Matrix<double, kSize, kSize>;

constexpr double kMinPriorEvidence = 1e-6;  // keeps the inverse of B finite for all priors

// Returns the value, or 0 if it was not measured.
double Positive(float value) { return IsMeasured(value) ? value : 0; }

// Maps [0, ∞) to [0, 1). The value 1, which is typical of these descriptors, gives ½.
double Squashed(float value) {
  const double positive = Positive(value);
  return positive / (1 + positive);
}

// Returns the logarithm of the count, scaled so that a million objects give 1.
double LogCount(float count) {
  return std::min(1.0, math::Log(1 + Positive(count)) / math::Log(1e6));
}

}  // namespace

LinTsPolicy::Features LinTsPolicy::FeaturesOf(const SceneDescriptor& descriptor) {
  return {1,
          LogCount(descriptor.object_count),
          Squashed(descriptor.density_ratio),
          Squashed(descriptor.size_spread),
          Squashed(descriptor.speed_mean),
          Squashed(descriptor.speed_spread),
          Squashed(descriptor.clustering_ratio),
          std::min(1.0, Positive(descriptor.static_ratio))};
}

LinTsPolicy::LinTsPolicy(const PolicySetup& setup)
    : RewardPolicy(setup), models_(setup.arms.size()), features_(FeaturesOf({})) {
  for (size_t arm = 0; arm < models_.size(); ++arm) {
    const BetaPosterior& prior = setup.priors[arm];
    const double evidence = std::max(prior.evidence(), kMinPriorEvidence);
    Matrix precision = Matrix::Identity();
    precision(0, 0) = evidence;
    Eigen::Map<Matrix>(models_[arm].precision.data()) = precision;
    models_[arm].response[0] = evidence * prior.mean();
  }
}

std::optional<WindowUpdate> LinTsPolicy::LearnWindow(const WindowObservation& observation) {
  const std::optional<WindowUpdate> update = RewardPolicy::LearnWindow(observation);
  if (update) Observe(update->increment);
  return update;
}

Increment LinTsPolicy::LearnBailOut(uint32_t arm) {
  const Increment increment = RewardPolicy::LearnBailOut(arm);
  Observe(increment);
  return increment;
}

void LinTsPolicy::LearnDescriptor(const SceneDescriptor& descriptor, int64_t /*now_ns*/) {
  features_ = FeaturesOf(descriptor);
}

// Adds α + β observations of the current scene, whose rewards sum to α.
void LinTsPolicy::Observe(const Increment& increment) {
  const Eigen::Map<const Vector> x(features_.data());
  Model& model = models_[increment.arm];
  Eigen::Map<Matrix>(model.precision.data()) +=
      (increment.alpha + increment.beta) * x * x.transpose();
  Eigen::Map<Vector>(model.response.data()) += increment.alpha * x;
}

LinTsPolicy::Belief LinTsPolicy::BeliefOf(const Model& model) const {
  const Eigen::Map<const Vector> x(features_.data());
  const Eigen::Map<const Vector> response(model.response.data());
  const Eigen::LLT<Matrix> factor(Eigen::Map<const Matrix>(model.precision.data()));
  const Vector weighted = factor.solve(x);  // B⁻¹x
  return {.mean = weighted.dot(response), .variance = std::max(0.0, weighted.dot(x))};
}

Choice LinTsPolicy::Choose(const ChoiceInput& input) const {
  std::vector<double> draws;
  // The distributions of the negative draws, because Diagnose takes the lowest value as the best.
  std::vector<double> means, variances;
  for (uint32_t arm = 0; arm < models_.size(); ++arm) {
    const Belief belief = BeliefOf(models_[arm]);
    means.push_back(-belief.mean);
    variances.push_back(kSpread * kSpread * belief.variance);
    RandomStream stream(input.seed, RandomPurpose::kChoice, input.decision_id, arm);
    draws.push_back(belief.mean + kSpread * std::sqrt(belief.variance) * DrawNormal(stream));
  }
  Choice choice = HighestOf(std::move(draws));
  const Diagnosis diagnosis = DiagnoseLogCosts(means, variances);
  choice.propensity = PropensityOfDraw(diagnosis, choice.candidate, models_.size());
  return choice;
}

}  // namespace sweepstake::decision
