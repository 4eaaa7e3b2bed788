// Beliefs about the arms' costs in each regime of the scene (regime_memory.h). When a regime
// returns, its beliefs are used again. A new regime starts from the beliefs of the present one,
// widened because every cost may have changed.
#pragma once

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
  // Assigns the descriptor to a regime and makes that regime the present one. Returns whether the
  // regime has changed.
  bool Observe(const SceneDescriptor& descriptor);

  // Whether the latest descriptor began a new regime.
  bool is_new() const { return is_new_; }
  // How often the regime has changed.
  uint64_t change_count() const { return change_count_; }

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

 private:
  RegimeMemory memory_;
  std::vector<RelativeCostFilter> filters_;  // one per regime
  uint32_t regime_ = 0;
  bool is_new_ = false;
  uint64_t change_count_ = 0;
};

}  // namespace sweepstake::decision
