#include "sweepstake/box2d.h"

#include <algorithm>
#include <utility>

namespace sweepstake {
namespace {

// A proxy sleeps after this number of searches without a change. bullet_broad_phase.cc has the
// reason for the number.
constexpr uint8_t kRestCount = 30;

// The number of updates without a search after which unused memory is freed, as by this number of
// searches (proxy_set.h).
constexpr uint32_t kUpdatesPerFreeing = 256;

// A query takes about as long as the search takes for this number of proxies (box2d_bench).
constexpr size_t kSearchedPerQuery = 8;

Aabb BoxOf(const b2AABB& aabb) {
  return {{aabb.lowerBound.x, aabb.lowerBound.y, 0}, {aabb.upperBound.x, aabb.upperBound.y, 0}};
}

// Frees the memory of a burst of proxies that has gone.
template <typename T>
void FreeIfSparse(std::vector<T>& list) {
  if (list.capacity() > 4 * list.size() + 1024) list.shrink_to_fit();
}

b2AABB Enlarge(const b2AABB& aabb, float margin) {
  const b2Vec2 both(margin, margin);
  b2AABB large;
  large.lowerBound = aabb.lowerBound - both;
  large.upperBound = aabb.upperBound + both;
  return large;
}

// Returns the fat box that b2DynamicTree::MoveProxy gives a proxy.
b2AABB FatBox(const b2AABB& aabb, const b2Vec2& displacement) {
  b2AABB fat = Enlarge(aabb, b2_aabbExtension);
  const b2Vec2 predicted = b2_aabbMultiplier * displacement;
  (predicted.x < 0 ? fat.lowerBound : fat.upperBound).x += predicted.x;
  (predicted.y < 0 ? fat.lowerBound : fat.upperBound).y += predicted.y;
  return fat;
}

}  // namespace

Box2dBroadPhase::Box2dBroadPhase(AdaptiveBroadPhase& search, Executor* executor)
    : search_(search), proxies_({.executor = executor}) {}

int32 Box2dBroadPhase::CreateProxy(const b2AABB& aabb, void* user_data) {
  const b2AABB fat = FatBox(aabb, {0, 0});
  const ProxyHandle handle = proxies_.Add(BoxOf(fat));
  if (handle.index == proxies_by_id_.size()) proxies_by_id_.emplace_back();
  proxies_by_id_[handle.index] = {.fat = fat, .user_data = user_data, .handle = handle};
  const auto id = static_cast<int32>(handle.index);
  TouchProxy(id);
  return id;
}

void Box2dBroadPhase::DestroyProxy(int32 id) {
  if (At(id).is_changed) std::erase(changed_, id);
  Rest(id);
  proxies_.Remove(std::exchange(At(id).handle, {}));
  while (!proxies_by_id_.empty() && proxies_by_id_.back().handle.is_null()) {
    proxies_by_id_.pop_back();
  }
  FreeIfSparse(proxies_by_id_);
  FreeIfSparse(awake_);
}

// Adds the proxy to those not at rest.
void Box2dBroadPhase::Wake(int32 id) {
  At(id).rest_count = 0;
  if (At(id).awake_at != kNotAwake) return;
  awake_.push_back(id);
  At(id).awake_at = static_cast<uint32_t>(awake_.size() - 1);
}

void Box2dBroadPhase::Rest(int32 id) {
  const uint32_t at = std::exchange(At(id).awake_at, kNotAwake);
  if (at == kNotAwake) return;
  const int32 last = awake_.back();
  awake_.pop_back();
  if (last == id) return;
  awake_[at] = last;
  At(last).awake_at = at;
}

void Box2dBroadPhase::TouchProxy(int32 id) {
  if (!std::exchange(At(id).is_changed, true)) changed_.push_back(id);
  Wake(id);
}

// Keeps the fat box while it contains the box and is not much larger than a new one, as Box2D does.
void Box2dBroadPhase::MoveProxy(int32 id, const b2AABB& aabb, const b2Vec2& displacement) {
  Proxy& proxy = At(id);
  const b2AABB fat = FatBox(aabb, displacement);
  if (proxy.fat.Contains(aabb) && Enlarge(fat, 4 * b2_aabbExtension).Contains(proxy.fat)) return;
  proxy.fat = fat;
  proxies_.Move(proxy.handle, BoxOf(fat));  // also wakes it
  TouchProxy(id);
}

std::span<const OverlapPair> Box2dBroadPhase::NewPairs() {
  pairs_.clear();
  // A query would leave pairs_exceeded() of the previous search.
  const bool may_query =
      !search_.pairs_exceeded() && changed_.size() * kSearchedPerQuery < proxies_.moving_count();
  if (!may_query || !QueryChanged()) {
    Search();
    if (search_.pairs_exceeded()) return pairs_;
  }
  for (const int32 id : changed_) At(id).is_changed = false;
  changed_.clear();
  sorter_.Sort(pairs_);
  return pairs_;
}

void Box2dBroadPhase::Search() {
  const auto found = search_.FindPairs(proxies_);
  if (search_.pairs_exceeded()) return;
  for (const auto& pair : found) {
    const bool is_new = proxies_by_id_[pair.a].is_changed || proxies_by_id_[pair.b].is_changed;
    if (is_new) pairs_.push_back(pair);
  }
  for (size_t k = awake_.size(); k-- > 0;) {  // backwards, since Rest moves the last one to k
    const int32 id = awake_[k];
    Proxy& proxy = At(id);
    if (proxy.is_changed || ++proxy.rest_count < kRestCount) continue;
    proxies_.SetSleeping(proxy.handle, true);
    Rest(id);
  }
}

// Returns false without a result if there are more pairs than max_pairs. A search then has more
// pairs too.
bool Box2dBroadPhase::QueryChanged() {
  const uint64_t max_pairs = search_.max_pairs();
  for (const int32 id : changed_) {
    const uint32_t own = At(id).handle.index;
    proxies_.QueryBox(BoxOf(At(id).fat), {}, found_);
    for (const auto& [other, generation] : found_) {
      // A pair of two changed proxies is found twice.
      if (other == own || (proxies_by_id_[other].is_changed && other > own)) continue;
      pairs_.push_back({std::min(own, other), std::max(own, other)});
    }
    if (max_pairs == 0 || pairs_.size() <= max_pairs) continue;
    pairs_.clear();
    return false;
  }
  if (++query_update_count_ % kUpdatesPerFreeing == 0) proxies_.FreeUnused();
  return true;
}

std::vector<ProxyHandle> Box2dBroadPhase::InBox(const b2AABB& aabb) const {
  std::vector<ProxyHandle> found;
  proxies_.QueryBox(BoxOf(aabb), {}, found);
  return found;
}

std::vector<RayHit> Box2dBroadPhase::OnRay(const b2RayCastInput& input) const {
  const b2Vec2 way = input.p2 - input.p1;
  std::vector<RayHit> hits;
  const Ray ray{{input.p1.x, input.p1.y, 0}, {way.x, way.y, 0}, input.maxFraction};
  (void)proxies_.CastRay(ray, {}, hits);  // finds nothing if a value is not finite
  return hits;
}

void Box2dBroadPhase::ShiftOrigin(const b2Vec2& new_origin) {
  const float offset[3] = {new_origin.x, new_origin.y, 0};
  if (!proxies_.ShiftOrigin(offset).ok()) return;  // not finite
  for (Proxy& proxy : proxies_by_id_) {
    proxy.fat.lowerBound -= new_origin;
    proxy.fat.upperBound -= new_origin;
  }
}

}  // namespace sweepstake
