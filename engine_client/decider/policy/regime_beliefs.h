// The beliefs about the arms' costs in each regime of the scene (regime_memory.h): those of a
// regime that returns come back with it, and those of a new one are the present ones, and wider,
// since every cost may have changed.
//
// A choice that lasts for some ticks cannot follow regimes that change in two of five ticks or more
// often. Then it is made by a mixture of them: of each arm the logarithm of its mean cost over the
// regimes, weighted by how often each of them was met of late.
//
// Not thread-safe. Deterministic.
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

  // Takes the descriptor of a tick. Returns whether what choices are made by has changed.
  bool Observe(const SceneDescriptor& descriptor);

  // The filter of the present regime, which is the one that learns.
  RelativeCostFilter& filter() { return filters_[regime_]; }
  const RelativeCostFilter& filter() const { return filters_[regime_]; }
  // Those of all regimes.
  std::span<RelativeCostFilter> filters() { return filters_; }
  bool scene_changes() const { return filters_.size() > 1; }  // it has had several regimes

  // What choices are made by.
  NormalBelief LogCost(uint32_t arm) const;
  double Covariance(uint32_t a, uint32_t b) const;
  // The belief about the difference of two log-costs, a's − b's.
  NormalBelief Difference(uint32_t a, uint32_t b) const;

 private:
  using Weights = std::array<double, RegimeMemory::kMaxRegimes>;

  // What the arm costs in each regime, times the ticks that it has had.
  Weights CostsOf(uint32_t arm) const;

  RegimeMemory memory_;
  std::vector<RelativeCostFilter> filters_;  // of each regime
  uint32_t regime_ = 0;
  Weights tick_shares_{};   // of the latest ticks, decaying; they need not add up to 1
  double change_rate_ = 0;  // of the regime, per tick
  bool mixes_ = false;
};

}  // namespace sweepstake::decision
