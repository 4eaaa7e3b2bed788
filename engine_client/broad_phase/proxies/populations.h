// Defines the numbers of the populations of a kind of proxies (proxy_kind.h): one per group of
// moving proxies, one per group of sleeping ones, and one for static ones. Also defines which
// proxies may share a group.
//
// The proxies of a group all ignore one another, like debris that collides with everything except
// debris. The search skips the pairs within a group, so that a pile of such proxies costs nothing.
// A proxy may join a group if no mask of the group or of the proxy contains:
// - the category of the proxy, or
// - a category of the group.
//
// Not thread-safe. Plain values, no allocation. Cost: O(kCount) per call.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "sweepstake/proxy_set.h"

namespace sweepstake {

class FilterGroups {
 public:
  // The number of groups. Group 0 holds all proxies that fit no other group; proxies of group 0 may
  // form pairs with one another.
  static constexpr uint32_t kCount = 8;

  // Returns the group that a proxy with this filter may join.
  uint32_t GroupFor(const CollisionFilter& filter) const {
    const CollisionFilter own = Counted(filter);
    for (uint32_t k = 1; k < kCount; ++k) {
      const CollisionFilter& all = groups_[k].all;
      if (((all.category | own.category) & (all.mask | own.mask)) == 0) return k;
    }
    return 0;
  }
  // REQUIRES: group == GroupFor(filter).
  void Join(uint32_t group, const CollisionFilter& filter) {
    if (group == 0) return;
    const CollisionFilter own = Counted(filter);
    groups_[group].all.category |= own.category;
    groups_[group].all.mask |= own.mask;
    ++groups_[group].count;
  }
  void Leave(uint32_t group) {
    if (group != 0 && --groups_[group].count == 0) groups_[group] = {};
  }

 private:
  // Returns the filter as it counts for a group. A filter without category or mask forms no pairs;
  // it counts as {0, 0}, which fits every group.
  static CollisionFilter Counted(const CollisionFilter& filter) {
    const bool passes_never = filter.category == 0 || filter.mask == 0;
    return passes_never ? CollisionFilter{0, 0} : filter;
  }

  struct Group {
    CollisionFilter all{0, 0};  // the union over all members, present and past
    size_t count = 0;
  };
  std::array<Group, kCount> groups_{};
};

inline constexpr uint8_t kSleepingPopulation = FilterGroups::kCount;
inline constexpr uint8_t kStaticPopulation = 2 * FilterGroups::kCount;
inline constexpr uint8_t kPopulations = kStaticPopulation + 1;

constexpr bool MovesIn(uint32_t population) { return population < kSleepingPopulation; }
constexpr bool IsStaticIn(uint32_t population) { return population == kStaticPopulation; }
constexpr bool SleepsIn(uint32_t population) {
  return !MovesIn(population) && !IsStaticIn(population);
}
constexpr uint32_t GroupOf(uint32_t population) {
  return IsStaticIn(population) ? 0 : population % FilterGroups::kCount;
}

}  // namespace sweepstake
