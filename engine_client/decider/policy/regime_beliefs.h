// Beliefs about the arms' costs in each regime of the scene (regime_memory.h). When a regime
// returns, its beliefs are used again. A new regime starts from the beliefs of the present one,
// widened because every cost may have changed.
//
// A choice lasts for several intervals. It cannot follow regimes that change twice in five
// intervals or more often. In that case choices use a mixture: per arm, the logarithm of its mean
// cost over the regimes, weighted by how often each regime occurred recently.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "engine_client/decider/policy/regime_memory.h"
#include "engine_client/decider/policy/relative_cost_filter.h"

namespace sweepstake::decision {

class RegimeBeliefs {
 public:
  explicit RegimeBeliefs(RelativeCostFilter first) : filters_(1, std::move(first)) {}

  DescriptorMatch Match(const SceneDescriptor& descriptor) const {
    return memory_.Match(descriptor);
  }
  // Assigns the descriptor to a regime and makes that regime the present one. `intervals` is the
  // time since the previous call, in decision intervals. Returns whether the beliefs that choices
  // use have changed.
  bool Observe(const SceneDescriptor& descriptor, double intervals);

  // The filter of the present regime, which is the only one that learns.
  RelativeCostFilter& filter() { return filters_[regime_]; }
  const RelativeCostFilter& filter() const { return filters_[regime_]; }
  // The filters of all regimes.
  std::span<RelativeCostFilter> filters() { return filters_; }
  // The filter of the regime at this place, from 0 on. REQUIRES: place < regime_count().
  const RelativeCostFilter& filter_at(uint32_t place) const { return filters_[place]; }
  uint32_t regime_count() const { return static_cast<uint32_t>(filters_.size()); }
  uint32_t present_place() const { return regime_; }
  const RegimeMemory& memory() const { return memory_; }
  bool scene_changes() const { return filters_.size() > 1; }  // more than one regime was seen

  // The belief that choices use.
  NormalBelief LogCost(uint32_t arm) const;
  double Covariance(uint32_t a, uint32_t b) const;
  // The belief about log-cost a − log-cost b.
  NormalBelief Difference(uint32_t a, uint32_t b) const;

 private:
  using Weights = std::array<double, RegimeMemory::kMaxRegimes>;

  // Returns, per regime, the arm's cost times the recent frequency of the regime.
  Weights CostsOf(uint32_t arm) const;

  RegimeMemory memory_;
  std::vector<RelativeCostFilter> filters_;  // one per regime
  uint32_t regime_ = 0;
  Weights shares_{};        // recent time in each regime; not normalised
  double change_rate_ = 0;  // changes of the regime per decision interval
  bool mixes_ = false;
};

}  // namespace sweepstake::decision
