// Finds the pairs that the broad phase does not search for: pairs between two populations of
// proxies, and pairs within each population but one (proxy_kind.h). It searches the trees of the
// populations.
//
// Two populations are searched in each frame if one of them moves and their filters may pass. Two
// resting populations (sleeping with sleeping or static) are searched only after one of them has
// changed; the pairs found are kept. Static proxies are not paired with one another, and neither
// are proxies of one group.
//
// The searches find rows (proxy_table.h); the results are ids, which stay the same while a proxy
// lives.
//
// Not thread-safe. Borrows the kinds and the executor. Owns the kept pairs. Cost: FindPairs
// O(leaves of the populations searched · log leaves + pairs), and O(kept pairs). Memory: 8 bytes
// per kept pair. Errors: std::bad_alloc from FindPairs, which may be called again.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "engine_client/broad_phase/common/parallel.h"
#include "engine_client/broad_phase/host/hook_points.h"
#include "engine_client/broad_phase/kd/kd_order.h"
#include "engine_client/broad_phase/proxies/proxy_kind.h"
#include "engine_client/broad_phase/proxies/snapshot.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/executor.h"
#include "sweepstake/pair_buffer.h"

namespace sweepstake {

class PopulationJoins {
 public:
  PopulationJoins(ProxyKind& moving, ProxyKind& resting, Executor* executor)
      : moving_(moving), resting_(resting), executor_(executor) {}

  // Determines which populations must be searched. Returns false if there are none and no pairs are
  // kept, so that FindPairs would find nothing. Must be called before FindPairs.
  bool Plan();
  // Appends all pairs that pass their filters, as ids with a < b. The order is the same for any
  // number of threads. Refreshes the trees. Reports the number of pairs to `stop`: found pairs
  // before the filters, and kept pairs. After a stop, `out` is undefined, and the next call may
  // follow.
  void FindPairs(KdOrder& splitter, StopRequest& stop, PairBuffer& out);

  // Frees its memory, except that of the kept pairs. Changes nothing if memory runs out.
  void FreeUnused();
  // Passes the fields of a snapshot to `archive` (snapshot.h).
  template <typename Self, typename Archive>
  static void Visit(Self& self, Archive& archive) {
    PairList kept(self.kept_);
    archive.Array(kept);
  }
  size_t native_bytes() const;

 private:
  struct Population {
    ProxyKind* kind;
    uint32_t number;

    const CollisionFilter& all() const { return kind->all(number); }
    const LeafTree& tree() const { return kind->tree(number); }
    bool moves() const { return MovesIn(number); }
    bool is_static() const { return IsStaticIn(number); }
    // Returns whether the broad phase, and not a join, finds the pairs within this population.
    bool is_searched() const { return kind->id_bit() == 0 && number == 0; }
  };
  struct Join {
    Population a;  // of the moving kind if the kinds differ
    Population b;  // may be the same as `a`
    bool within_one() const { return a.kind == b.kind && a.number == b.number; }
  };

  static bool MayForm(const Join& join);
  void PlanWith(const Population& a, const Population& b);
  uint64_t Search(const Join& join, StopRequest& stop, PairBuffer& out);
  uint64_t SearchBetween(const Join& join, StopRequest& stop, PairBuffer& out);
  void FinishPairs(const Join& join, size_t first, PairBuffer& out) const;
  void SearchAndNote(std::span<const Join> joins, StopRequest& stop, PairBuffer& out);
  void SearchResting(StopRequest& stop);

  ProxyKind& moving_;
  ProxyKind& resting_;
  Executor* executor_;
  HookedVector<Population> populations_;
  HookedVector<Join> of_moving_;   // joins with at least one moving population
  HookedVector<Join> of_resting_;  // joins of two resting populations
  PairBuffer kept_;                // the pairs of `of_resting_`
  PairParts parts_;
};

inline void Append(std::span<const OverlapPair> pairs, PairBuffer& out) {
  std::copy(pairs.begin(), pairs.end(), out.EnsureRoom(pairs.size()));
  out.Advance(pairs.size());
}

// Returns the same pair with the smaller id first.
constexpr OverlapPair Ascending(const OverlapPair& pair) {
  return {std::min(pair.a, pair.b), std::max(pair.a, pair.b)};
}

}  // namespace sweepstake
