#include "engine_client/broad_phase/proxies/pair_events.h"

#include <utility>

#include "engine_client/broad_phase/proxies/populations.h"

namespace sweepstake {
namespace {

bool AreWithin(const Aabb& a, const Aabb& b, float margin) {
  if (!IsValid(a) || !IsValid(b)) return false;
  for (int axis = 0; axis < 3; ++axis) {
    if (a.min[axis] - b.max[axis] > margin || b.min[axis] - a.max[axis] > margin) return false;
  }
  return true;
}

}  // namespace

ProxyPair PairEvents::HandlesOf(const OverlapPair& pair) const {
  const ProxyTable& table_a = TableOf(pair.a);
  const ProxyTable& table_b = TableOf(pair.b);
  return {table_a.handle(table_a.RowOf(pair.a)), table_b.handle(table_b.RowOf(pair.b))};
}

bool PairEvents::GoesOn(const ProxyPair& pair, float margin) const {
  const ProxyTable& table_a = TableOf(pair.a.index);
  const ProxyTable& table_b = TableOf(pair.b.index);
  const uint32_t a = table_a.Find(pair.a);
  const uint32_t b = table_b.Find(pair.b);
  if (a == ProxyTable::kNoRow || b == ProxyTable::kNoRow) return false;
  if (IsStaticIn(table_a.population(a)) && IsStaticIn(table_b.population(b))) return false;
  return Passes(table_a.filters()[a], table_b.filters()[b]) &&
         AreWithin(table_a.boxes()[a], table_b.boxes()[b], margin);
}

void PairEvents::Update(std::span<const OverlapPair> now, float margin) {
  Clear();
  next_begun_.resize(now.size() + (margin > 0 ? begun_.size() : 0));
  ProxyPair* next = next_begun_.data();
  // Fills local lists first. If memory runs out, added_ and removed_ are then empty instead of
  // incomplete.
  HookedVector<ProxyPair> added = std::move(added_);
  HookedVector<ProxyPair> removed = std::move(removed_);
  const bool any_removed = moving_.any_removed() || resting_.any_removed();
  const auto end = [&](const ProxyPair& pair) {
    if (margin > 0 && GoesOn(pair, margin)) {
      *next++ = pair;
    } else {
      removed.push_back(pair);
    }
  };
  const auto begin = [&](const OverlapPair& pair) {
    added.push_back(HandlesOf(pair));
    *next++ = added.back();
  };
  size_t b = 0;
  for (const OverlapPair& pair : now) {
    const uint64_t key = PairKey(pair);
    while (b < begun_.size() && PairKey(begun_[b]) < key) end(begun_[b++]);
    if (b == begun_.size() || PairKey(begun_[b]) != key) {
      begin(pair);
      continue;
    }
    // Most pairs persist, so that this branch is well predicted.
    const ProxyPair& same_ids = begun_[b++];
    if (!any_removed || (Lives(same_ids.a) && Lives(same_ids.b))) {
      *next++ = same_ids;
    } else {
      removed.push_back(same_ids);
      begin(pair);
    }
  }
  while (b < begun_.size()) end(begun_[b++]);
  next_begun_.resize(static_cast<size_t>(next - next_begun_.data()));
  begun_.swap(next_begun_);
  added_ = std::move(added);
  removed_ = std::move(removed);
}

void PairEvents::FreeUnused() {
  // shrink_to_fit would ignore a failed allocation, and the memory would never be freed.
  HookedVector<ProxyPair>(begun_).swap(begun_);
  HookedVector<ProxyPair>(added_).swap(added_);
  HookedVector<ProxyPair>(removed_).swap(removed_);
  next_begun_ = HookedVector<ProxyPair>();
}

}  // namespace sweepstake
