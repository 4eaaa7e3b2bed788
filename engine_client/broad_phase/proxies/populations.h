// The populations of a kind of proxies (proxy_kind.h), as numbers: the groups of those that move
// (filter_groups.h), the groups of those that sleep, and the static ones. Stateless.
#pragma once

#include <cstdint>

#include "engine_client/broad_phase/proxies/filter_groups.h"

namespace sweepstake {

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
