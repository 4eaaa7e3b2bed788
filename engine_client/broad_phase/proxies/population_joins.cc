#include "engine_client/broad_phase/proxies/population_joins.h"

#include <utility>

#include "engine_client/broad_phase/proxies/tree_walk.h"

namespace sweepstake {
namespace {

// The minimum work per part of a parallel loop. A smaller part takes less time than waking a
// thread.
constexpr size_t kMinLeavesPerPart = 32;
constexpr size_t kMinBlocksPerPart = 2;

}  // namespace

bool PopulationJoins::MayForm(const Join& join) {
  if (join.a.is_static() && join.b.is_static()) return false;
  if (join.within_one() && join.a.is_searched()) return false;
  const uint32_t group = GroupOf(join.a.number);
  if (group != 0 && group == GroupOf(join.b.number)) return false;
  return Passes(join.a.all(), join.b.all());
}

void PopulationJoins::PlanWith(const Population& a, const Population& b) {
  const Join join{a, b};
  if (!MayForm(join)) return;
  (a.moves() || b.moves() ? of_moving_ : of_resting_).push_back(join);
}

bool PopulationJoins::Plan() {
  populations_.clear();
  of_moving_.clear();
  of_resting_.clear();
  for (ProxyKind* const kind : {&moving_, &resting_}) {
    for (uint32_t number = 0; number < kPopulations; ++number) {
      if (kind->count(number) > 0) populations_.push_back({kind, number});
    }
  }
  for (size_t i = 0; i < populations_.size(); ++i) {
    for (size_t k = i; k < populations_.size(); ++k) PlanWith(populations_[i], populations_[k]);
  }
  return !of_moving_.empty() || !of_resting_.empty();
}

void PopulationJoins::FindPairs(KdOrder& splitter, StopRequest& stop, PairBuffer& out) {
  moving_.RefreshTrees(splitter);
  resting_.RefreshTrees(splitter);
  SearchAndNote(of_moving_, stop, out);
  if (moving_.any_resting_changed() || resting_.any_resting_changed()) {
    SearchResting(stop);
  } else {
    stop.WantsStop(0, kept_.size());
  }
  if (!IsStopped(&stop)) Append(kept_.pairs(), out);
}

// After a stop, no pairs are kept, and the next call searches again.
void PopulationJoins::SearchResting(StopRequest& stop) {
  kept_.Clear();
  for (const Join& join : of_resting_) Search(join, stop, kept_);
  if (IsStopped(&stop)) return kept_.Clear();
  moving_.MarkRestingSeen();
  resting_.MarkRestingSeen();
}

// Searches all joins, each for the pairs of two populations `a` and `b`. Joins with the same `a`
// are consecutive, and the sum of their checks is reported to the tree of `a`, unless the search
// was stopped.
void PopulationJoins::SearchAndNote(std::span<const Join> joins, StopRequest& stop,
                                    PairBuffer& out) {
  for (size_t k = 0; k < joins.size();) {
    const Population& a = joins[k].a;
    uint64_t checks = 0;
    for (; k < joins.size() && joins[k].a.kind == a.kind && joins[k].a.number == a.number; ++k) {
      checks += Search(joins[k], stop, out);
    }
    if (IsStopped(&stop)) return;
    a.kind->NoteSearch(a.number, checks);
  }
}

uint64_t PopulationJoins::Search(const Join& join, StopRequest& stop, PairBuffer& out) {
  if (IsStopped(&stop)) return 0;
  const size_t first = out.size();
  uint64_t checks = 0;
  if (join.within_one()) {
    const LeafTree& tree = join.a.tree();
    checks = parts_.Run(
        executor_, tree.block_count(), kMinBlocksPerPart, 1, out,
        [&](size_t begin, size_t end, PairBuffer& pairs) {
          return tree.FindPairs(begin, end, pairs, &stop);
        },
        &stop);
  } else {
    checks = SearchBetween(join, stop, out);
  }
  FinishPairs(join, first, out);
  return checks;
}

uint64_t PopulationJoins::SearchBetween(const Join& join, StopRequest& stop, PairBuffer& out) {
  const LeafTree::View& leaves = join.a.tree().view();
  const LeafTree::View& tree = join.b.tree().view();
  const uint32_t other_bit = join.a.kind == join.b.kind ? 0 : join.b.kind->id_bit();
  return parts_.Run(
      executor_, leaves.levels[1].count, kMinLeavesPerPart, LeafTree::kWidth, out,
      [&](size_t begin, size_t end, PairBuffer& pairs) {
        return FindPairsBetween(leaves, begin, end, tree, other_bit, pairs, &stop);
      },
      &stop);
}

// Replaces the rows that a search has found by ids. Drops pairs that do not pass the filters.
void PopulationJoins::FinishPairs(const Join& join, size_t first, PairBuffer& out) const {
  const std::span<OverlapPair> found = out.pairs().subspan(first);
  // A search in one kind finds rows without the kind's bit, a search in both adds it.
  if (const uint32_t bit = join.a.kind->id_bit(); join.a.kind == join.b.kind && bit != 0) {
    for (OverlapPair& pair : found) pair = {pair.a | bit, pair.b | bit};
  }
  const ProxyTable& moving = moving_.table();
  const ProxyTable& resting = resting_.table();
  const bool all_pass = moving.all_pass() && resting.all_pass();
  if (all_pass && moving.ids_are_rows() && resting.ids_are_rows()) return;
  const auto table_of = [&](uint32_t row) -> const ProxyTable& {
    return (row & kStaticProxyBit) != 0 ? resting : moving;
  };
  size_t count = first;
  for (const OverlapPair pair : found) {
    const ProxyTable& table_a = table_of(pair.a);
    const ProxyTable& table_b = table_of(pair.b);
    const uint32_t a = pair.a & ~kStaticProxyBit;
    const uint32_t b = pair.b & ~kStaticProxyBit;
    out.pairs()[count] = Ascending({table_a.id(a), table_b.id(b)});
    count += static_cast<size_t>(all_pass || Passes(table_a.filters()[a], table_b.filters()[b]));
  }
  out.Truncate(count);
}

void PopulationJoins::FreeUnused() {
  PairBuffer kept;
  if (!kept_.empty()) Append(kept_.pairs(), kept);
  kept_ = std::move(kept);
  parts_ = PairParts();
}

size_t PopulationJoins::native_bytes() const {
  return kept_.capacity_bytes() + parts_.native_bytes() +
         populations_.capacity() * sizeof(Population) +
         (of_moving_.capacity() + of_resting_.capacity()) * sizeof(Join);
}

}  // namespace sweepstake
