#include "sweepstake/box2d.h"

#include <utility>

namespace sweepstake {
namespace {

// A proxy sleeps after this number of updates without a move. bullet_broad_phase.cc has the reason
// for the number.
constexpr uint32_t kRestCount = 30;

Aabb BoxOf(const b2AABB& aabb) {
  return {{aabb.lowerBound.x, aabb.lowerBound.y, 0}, {aabb.upperBound.x, aabb.upperBound.y, 0}};
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
  return static_cast<int32>(handle.index);
}

void Box2dBroadPhase::DestroyProxy(int32 id) { proxies_.Remove(At(id).handle); }

// Keeps the fat box while it contains the box and is not much larger than a new one, as Box2D does.
void Box2dBroadPhase::MoveProxy(int32 id, const b2AABB& aabb, const b2Vec2& displacement) {
  Proxy& proxy = At(id);
  const b2AABB fat = FatBox(aabb, displacement);
  if (proxy.fat.Contains(aabb) && Enlarge(fat, 4 * b2_aabbExtension).Contains(proxy.fat)) return;
  proxy.fat = fat;
  proxy.is_moved = true;
  proxies_.Move(proxy.handle, BoxOf(fat));  // also wakes it
}

std::span<const OverlapPair> Box2dBroadPhase::NewPairs() {
  pairs_.clear();
  for (const auto& pair : proxies_.Resolve(search_.FindPairs(proxies_.moving_boxes()))) {
    if (proxies_by_id_[pair.a].is_moved || proxies_by_id_[pair.b].is_moved) pairs_.push_back(pair);
  }
  sorter_.Sort(pairs_);
  for (Proxy& proxy : proxies_by_id_) {
    if (std::exchange(proxy.is_moved, false)) {
      proxy.rest_count = 0;
    } else if (proxy.rest_count < kRestCount && ++proxy.rest_count == kRestCount) {
      proxies_.SetSleeping(proxy.handle, true);
    }
  }
  return pairs_;
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
