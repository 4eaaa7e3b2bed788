#include "engine_client/broad_phase/proxies/pair_events.h"

#include <algorithm>
#include <utility>

#include "engine_client/broad_phase/proxies/populations.h"

namespace sweepstake {
namespace {

// Maps the ids of a pair to the two proxies that own them, in this frame (Now) and in the last
// frame (Before). If a proxy is removed and another one is added, the new proxy may get the id and
// become its new owner.
class Owners {
 public:
  Owners(const ProxyTable& moving, const ProxyTable& resting)
      : moving_(moving),
        resting_(resting),
        any_new_(moving.any_new_owner() || resting.any_new_owner()) {}

  ProxyPair Now(const OverlapPair& pair) const {
    return {{pair.a, TableOf(pair.a).generation(PlaceOf(pair.a))},
            {pair.b, TableOf(pair.b).generation(PlaceOf(pair.b))}};
  }
  ProxyPair Before(const OverlapPair& pair) const {
    return {{pair.a, TableOf(pair.a).seen_generation(PlaceOf(pair.a))},
            {pair.b, TableOf(pair.b).seen_generation(PlaceOf(pair.b))}};
  }
  // Returns whether one of the ids has another owner than in the last frame. Such a pair counts as
  // new.
  bool Changed(const OverlapPair& pair) const {
    return any_new_ && (TableOf(pair.a).HasNewOwner(PlaceOf(pair.a)) ||
                        TableOf(pair.b).HasNewOwner(PlaceOf(pair.b)));
  }

 private:
  static uint32_t PlaceOf(uint32_t id) { return id & ~kStaticProxyBit; }
  const ProxyTable& TableOf(uint32_t id) const {
    return (id & kStaticProxyBit) != 0 ? resting_ : moving_;
  }

  const ProxyTable& moving_;
  const ProxyTable& resting_;
  const bool any_new_;
};

bool AreWithin(const Aabb& a, const Aabb& b, float margin) {
  if (!IsValid(a) || !IsValid(b)) return false;
  for (int axis = 0; axis < 3; ++axis) {
    if (a.min[axis] - b.max[axis] > margin || b.min[axis] - a.max[axis] > margin) return false;
  }
  return true;
}

// Returns whether a pair of the last frame continues: each id still belongs to the same proxy, the
// filters pass, not both are static, and the boxes are at most `margin` apart on each axis.
bool GoesOn(const OverlapPair& pair, float margin, const ProxyTable& moving,
            const ProxyTable& resting) {
  const ProxyTable* tables[2];
  uint32_t places[2];
  bool all_static = true;
  for (size_t k = 0; k < 2; ++k) {
    const uint32_t id = k == 0 ? pair.a : pair.b;
    tables[k] = (id & kStaticProxyBit) != 0 ? &resting : &moving;
    places[k] = id & ~kStaticProxyBit;
    if (!tables[k]->Holds(places[k], tables[k]->seen_generation(places[k]))) return false;
    all_static = all_static && IsStaticIn(tables[k]->population(places[k]));
  }
  return !all_static && Passes(tables[0]->filters()[places[0]], tables[1]->filters()[places[1]]) &&
         AreWithin(tables[0]->boxes()[places[0]], tables[1]->boxes()[places[1]], margin);
}

}  // namespace

void PairEvents::Hold(std::span<const OverlapPair> before, std::span<const OverlapPair> now,
                      float margin, const ProxyTable& moving, const ProxyTable& resting,
                      PairBuffer& out) {
  OverlapPair* to = out.EnsureRoom(before.size() + now.size());
  const OverlapPair* const first = to;
  size_t n = 0;
  for (const OverlapPair& pair : before) {
    while (n < now.size() && PairKey(now[n]) < PairKey(pair)) *to++ = now[n++];
    if (n < now.size() && now[n] == pair) continue;
    if (GoesOn(pair, margin, moving, resting)) *to++ = pair;
  }
  to = std::copy(now.begin() + static_cast<std::ptrdiff_t>(n), now.end(), to);
  out.Advance(static_cast<size_t>(to - first));
}

void PairEvents::Compare(std::span<const OverlapPair> before, std::span<const OverlapPair> now,
                         const ProxyTable& moving, const ProxyTable& resting) {
  const Owners owners(moving, resting);
  Clear();
  // Fills local lists first. If memory runs out, added_ and removed_ are then empty instead of
  // incomplete.
  HookedVector<ProxyPair> added = std::move(added_);
  HookedVector<ProxyPair> removed = std::move(removed_);
  size_t b = 0;
  size_t n = 0;
  while (b < before.size() && n < now.size()) {
    const uint64_t key_before = PairKey(before[b]);
    const uint64_t key_now = PairKey(now[n]);
    // Most pairs persist, so that this branch is well predicted.
    if (key_before == key_now && !owners.Changed(now[n])) {
      ++b;
      ++n;
      continue;
    }
    if (key_before <= key_now) removed.push_back(owners.Before(before[b++]));
    if (key_now <= key_before) added.push_back(owners.Now(now[n++]));
  }
  while (b < before.size()) removed.push_back(owners.Before(before[b++]));
  while (n < now.size()) added.push_back(owners.Now(now[n++]));
  added_ = std::move(added);
  removed_ = std::move(removed);
}

}  // namespace sweepstake
