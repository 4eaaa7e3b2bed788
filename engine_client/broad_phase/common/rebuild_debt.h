// Decides when a structure that motion has degraded is worth rebuilding, and over how many frames
// to spread the rebuild.
//
// The older a structure is, the more checks a search in it makes. Its debt is the number of checks
// in excess of the cheapest search, summed over the searches since the latest rebuild. A rebuild is
// due when the debt exceeds the cost of the rebuild. Searches and rebuilds together then cost at
// most twice as much as with the best possible times for the rebuilds.
//
// Not thread-safe: plain values. Units: AABB checks, or a fixed multiple of them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

namespace sweepstake {

class RebuildDebt {
 public:
  // Must be called when the structure has been rebuilt.
  void Clear() { *this = {}; }
  // Must be called after each search, with its number of checks.
  void AddSearch(uint64_t checks) {
    min_checks_ = std::min(min_checks_, checks);
    excess_checks_ += checks - min_checks_;
  }
  bool Exceeds(uint64_t rebuild_cost) const { return excess_checks_ > rebuild_cost; }

 private:
  uint64_t min_checks_ = std::numeric_limits<uint64_t>::max();
  uint64_t excess_checks_ = 0;
};

// Returns the cost of a search in checks. Writing a pair counts as 8 checks. With 4 or 16 instead,
// KDTree's mean frame time changes by at most 3 % with AVX-512, AVX2 and SSE4 (`sweepstake-lab
// bench`, suites b and g).
constexpr uint64_t SearchCost(uint64_t checks, uint64_t pair_count) {
  return checks + 8 * pair_count;
}

// Returns the number of frames, 1 to 6, over which to spread a rebuild so that no frame costs much
// more than its search.
constexpr uint64_t RebuildFrames(uint64_t rebuild_cost, uint64_t search_cost) {
  return std::clamp<uint64_t>(3 * rebuild_cost / (search_cost + 1), 1, 6);
}

}  // namespace sweepstake
