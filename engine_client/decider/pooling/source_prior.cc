#include "engine_client/decider/pooling/source_prior.h"

#include <algorithm>
#include <cmath>  // std::abs, and std::sqrt, exactly rounded by IEEE 754
#include <optional>
#include <utility>

#include "engine_client/decider/policy/log_cost.h"

namespace sweepstake::decision {
namespace {

// Exponents of the power prior (PowerPriorWeight): the two weights by the source's build, and the
// factors for another machine class and for another version of the arm. Chosen, not measured.
constexpr double kSameBuildWeight = 0.5;
constexpr double kOtherBuildWeight = 0.25;
constexpr double kOtherMachineClassFactor = 0.2;
constexpr double kOtherBackendVersionFactor = 0.04;

constexpr int kPolishSteps = 8;  // chosen; a median polish converges within a few steps (Tukey)
// Assumed variance of an arm's relative log-cost between sources, and the number of sources that
// this assumption counts as.
constexpr double kSourceVariance = 0.1 * 0.1;
constexpr double kGuessWeight = 4;
// The deviation is estimated from a quantile of the distances from the centre: 70 % of a normal
// distribution lie within kWithinDeviations. The median distance is not used, because it would be 0
// if just over half of the sources agree exactly.
constexpr double kWithinShare = 0.7;
constexpr double kWithinDeviations = 1.0364;
// Measurements farther than this from the common value are dropped, in standard deviations.
constexpr double kDroppedDeviations = 5;
// The variance of a median ÷ the variance of a mean: π/2.
constexpr double kMedianVariance = 1.5707963267948966;

struct Weighed {
  double value = 0;
  double weight = 0;
};

// Returns the weighted quantile: `share` of the total weight lies below it. 0 if there are no
// values.
double QuantileOf(std::vector<Weighed> values, double share) {
  std::sort(values.begin(), values.end(),
            [](const Weighed& a, const Weighed& b) { return a.value < b.value; });
  double rest = 0;
  for (const Weighed& value : values) rest += value.weight * share;
  for (size_t i = 0; i < values.size(); ++i) {
    rest -= values[i].weight;
    if (rest > 0) continue;
    const bool between = rest == 0 && i + 1 < values.size();
    return between ? (values[i].value + values[i + 1].value) / 2 : values[i].value;
  }
  return 0;
}

double MedianOf(std::vector<Weighed> values) { return QuantileOf(std::move(values), 0.5); }

// One source's measurement of one arm.
struct Cell {
  size_t source = 0;
  size_t arm = 0;
  NormalBelief log_cost;
  double weight = 0;
};

NormalBelief BeliefOf(const EvidenceSum& sum) {
  return BeliefOf(BetaPosterior{.alpha = sum.alpha, .beta = sum.beta});
}

EvidenceSum SumOf(const NormalBelief& log_cost) {
  const double mean = std::clamp(RewardOf(log_cost.mean), 0.0, 1.0);
  const double evidence = EvidenceOf(mean, log_cost.variance);
  return {.alpha = evidence * mean, .beta = evidence * (1 - mean)};
}

class MedianPolish {
 public:
  MedianPolish(std::span<const SourceEvidence> sources, size_t arm_count)
      : levels_(sources.size()), arms_(arm_count) {
    for (size_t source = 0; source < sources.size(); ++source) {
      for (size_t arm = 0; arm < arm_count; ++arm) {
        const auto& [sum, weight] = sources[source][arm];
        if (sum.evidence() > 0) cells_.push_back({source, arm, BeliefOf(sum), weight});
      }
    }
    LimitPrecisions();
    Polish();
    DropOutliers();
    Polish();
  }

  // Returns the belief about the arm's log-cost for a session at that level. Returns nothing if no
  // source has evidence of the arm.
  std::optional<NormalBelief> BeliefAt(double level, size_t arm) const {
    const auto count =
        std::count_if(cells_.begin(), cells_.end(), [&](auto& cell) { return cell.arm == arm; });
    if (count == 0) return std::nullopt;
    const auto others = static_cast<double>(count - 1);
    const double deviation = DeviationOf(arm);
    const double between =
        (kGuessWeight * kSourceVariance + others * deviation * deviation) / (kGuessWeight + others);
    double precision = 0;
    for (const Cell& cell : cells_) precision += cell.arm == arm ? WeightOf(cell, between) : 0;
    const double of_centre = (others > 1 ? kMedianVariance : 1) / precision;
    return NormalBelief{.mean = level + arms_[arm], .variance = between + of_centre};
  }

  // Returns the level of a session with the evidence `own`, or the typical level of the sources if
  // it has none.
  double LevelOf(std::span<const EvidenceSum> own) const {
    std::vector<Weighed> levels;
    for (size_t arm = 0; arm < own.size(); ++arm) {
      if (!(own[arm].evidence() > 0)) continue;
      const NormalBelief belief = BeliefOf(own[arm]);
      levels.push_back({belief.mean - arms_[arm], 1 / (belief.variance + kSourceVariance)});
    }
    if (levels.empty()) {
      for (const Cell& cell : cells_) levels.push_back({levels_[cell.source], cell.weight});
    }
    return MedianOf(std::move(levels));
  }

 private:
  static double WeightOf(const Cell& cell, double between) {
    return cell.weight / (cell.log_cost.variance + between);
  }

  double ResidualOf(const Cell& cell) const {
    return cell.log_cost.mean - levels_[cell.source] - arms_[cell.arm];
  }

  // Returns the standard deviation of the sources' measurements of the arm around their common
  // value.
  double DeviationOf(size_t arm) const {
    std::vector<Weighed> distances;
    for (const Cell& cell : cells_) {
      if (cell.arm == arm)
        distances.push_back({std::abs(ResidualOf(cell)), WeightOf(cell, kSourceVariance)});
    }
    return QuantileOf(std::move(distances), kWithinShare) / kWithinDeviations;
  }

  // Raises the variance of each cell to at least the median variance of its arm. So a source gains
  // no weight by claiming to be certain.
  void LimitPrecisions() {
    std::vector<std::vector<Weighed>> variances(arms_.size());
    for (const Cell& cell : cells_) variances[cell.arm].push_back({cell.log_cost.variance, 1});
    std::vector<double> medians;
    for (auto& of_arm : variances) medians.push_back(MedianOf(std::move(of_arm)));
    for (Cell& cell : cells_)
      cell.log_cost.variance = std::max(cell.log_cost.variance, medians[cell.arm]);
  }

  // Removes outliers, because even in a median each outlier moves the result a little to its side.
  void DropOutliers() {
    std::vector<double> reaches;
    for (size_t arm = 0; arm < arms_.size(); ++arm)
      reaches.push_back(kDroppedDeviations *
                        std::max(DeviationOf(arm), std::sqrt(kSourceVariance)));
    std::erase_if(cells_,
                  [&](const Cell& cell) { return std::abs(ResidualOf(cell)) > reaches[cell.arm]; });
  }

  // One step of the median polish. Subtracts the other effects from each cell, and sets each of
  // `effects` to the median of what is left.
  void Sweep(size_t Cell::*index, std::vector<double>& effects) {
    std::vector<std::vector<Weighed>> left(effects.size());
    for (const Cell& cell : cells_) {
      const size_t i = cell.*index;
      left[i].push_back({ResidualOf(cell) + effects[i], WeightOf(cell, kSourceVariance)});
    }
    for (size_t i = 0; i < effects.size(); ++i) effects[i] = MedianOf(std::move(left[i]));
  }

  void Polish() {
    for (int step = 0; step < kPolishSteps; ++step) {
      Sweep(&Cell::source, levels_);
      Sweep(&Cell::arm, arms_);
    }
  }

  std::vector<Cell> cells_;
  std::vector<double> levels_;  // one per source
  std::vector<double> arms_;    // one per arm, relative to the source's level
};

}  // namespace

double PowerPriorWeight(const SourceRelation& relation) {
  return (relation.same_build ? kSameBuildWeight : kOtherBuildWeight) *
         (relation.same_machine_class ? 1 : kOtherMachineClassFactor) *
         (relation.same_backend_version ? 1 : kOtherBackendVersionFactor);
}

std::vector<EvidenceSum> CombineSources(std::span<const SourceEvidence> sources,
                                        std::span<const EvidenceSum> own) {
  const MedianPolish polish(sources, own.size());
  const double level = polish.LevelOf(own);
  std::vector<EvidenceSum> priors(own.begin(), own.end());
  for (size_t arm = 0; arm < own.size(); ++arm) {
    const std::optional<NormalBelief> belief = polish.BeliefAt(level, arm);
    if (!belief) continue;
    const EvidenceSum sum = SumOf(*belief);
    priors[arm].alpha += sum.alpha;
    priors[arm].beta += sum.beta;
  }
  return priors;
}

}  // namespace sweepstake::decision
