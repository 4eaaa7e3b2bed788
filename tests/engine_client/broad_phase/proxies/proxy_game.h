// A random game on a ProxySet, and on a list that is searched by the definitions. Proxies are
// added, removed, moved, teleported, invalidated, put to sleep, made static and get new filters.
// Now and then the origin is shifted, and many proxies come and go at once.
//
// The same seed gives the same game. Not thread-safe.
#pragma once

#include <algorithm>
#include <limits>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "engine_client/scene/random.h"
#include "sweepstake/proxy_set.h"

namespace sweepstake::test_support {

inline constexpr Aabb kUnit = {{0, 0, 0}, {1, 1, 1}};
inline constexpr Aabb kTouching = {{1, 1, 1}, {2, 2, 2}};  // touches a corner of kUnit

struct ListedProxy {
  ProxyHandle handle;
  Aabb box;
  ProxyOptions options;
};

using ProxyPairs = std::set<ProxyPair>;

inline ProxyPairs PairsByDefinition(std::span<const ListedProxy> listed) {
  ProxyPairs pairs;
  for (size_t i = 0; i < listed.size(); ++i) {
    for (size_t k = i + 1; k < listed.size(); ++k) {
      const ListedProxy& a = listed[i];
      const ListedProxy& b = listed[k];
      if (a.options.is_static && b.options.is_static) continue;
      if (!Overlap(a.box, b.box) || !Passes(a.options.filter, b.options.filter)) continue;
      pairs.insert({std::min(a.handle, b.handle), std::max(a.handle, b.handle)});
    }
  }
  return pairs;
}

class ProxyGame {
 public:
  ProxyGame(const ProxySetOptions& options, uint64_t seed, float world = 8)
      : proxies(options), random_(seed), world_(world) {}

  void AddSome(size_t moving_count, size_t static_count) {
    for (size_t k = 0; k < moving_count + static_count; ++k) Add(k >= moving_count);
  }

  // Makes the changes between two frames.
  void Step() {
    for (size_t k = random_.Below(6); k > 0; --k) Add(random_.Below(3) == 0);
    for (size_t k = random_.Below(4); k > 0 && !listed.empty(); --k) Remove();
    for (ListedProxy& proxy : listed) {
      const bool rests = proxy.options.is_static || proxies.is_sleeping(proxy.handle);
      const bool moves = rests ? random_.Below(200) == 0 : random_.Below(4) != 0;
      if (moves) MoveTo(proxy, Moved(proxy.box));
    }
    for (size_t k = random_.Below(3); k > 0 && !listed.empty(); --k) {
      ListedProxy& proxy = Any();
      proxy.options.filter = RandomFilter();
      failed |= !proxies.SetFilter(proxy.handle, proxy.options.filter);
    }
    if (!listed.empty()) Rest();
    if (random_.Below(25) == 0) ShiftOrigin();
    if (burst_.empty()) {
      if (random_.Below(30) == 0) BeginBurst();
    } else if (random_.Below(3) == 0) {
      EndBurst();
    }
  }

  void BeginBurst() {
    for (size_t k = 50 + random_.Below(150); k > 0; --k) {
      Add(random_.Below(3) == 0);
      burst_.push_back(listed.back().handle);
      failed |= !proxies.SetSleeping(burst_.back(), random_.Below(4) == 0);
    }
  }

  // Removes all proxies of the burst or all but the last one, which has the highest id.
  void EndBurst() {
    if (random_.Below(2) == 0) burst_.pop_back();
    const auto ends = [this](const ListedProxy& proxy) {
      return std::ranges::find(burst_, proxy.handle) != burst_.end();
    };
    std::vector<ProxyHandle> ended;
    for (const ListedProxy& proxy : listed) {
      if (ends(proxy)) ended.push_back(proxy.handle);
    }
    failed |= !proxies.RemoveMany(ended);
    gone.insert(gone.end(), ended.begin(), ended.end());
    std::erase_if(listed, ends);
    burst_.clear();
  }

  // Puts some proxies to sleep, wakes some, and may make one static or moving. Static proxies and
  // proxies that move do not sleep.
  void Rest() {
    for (size_t k = random_.Below(12); k > 0; --k) {
      failed |= !proxies.SetSleeping(Any().handle, random_.Below(4) != 0);
    }
    if (random_.Below(2) == 0) return;
    ListedProxy& proxy = Any();
    proxy.options.is_static = !proxy.options.is_static;
    failed |= !proxies.SetStatic(proxy.handle, proxy.options.is_static);
  }

  // Shifts the origin by eighths, which change box coordinates without rounding, or by arbitrary
  // values.
  void ShiftOrigin() {
    const bool exact = random_.Below(2) == 0;
    float offset[3];
    for (float& along : offset) along = exact ? 0.125F : random_.Symmetric();
    failed |= !proxies.ShiftOrigin(offset).ok();
    for (ListedProxy& proxy : listed) {
      if (!IsValid(proxy.box)) continue;
      for (int axis = 0; axis < 3; ++axis) {
        proxy.box.min[axis] -= offset[axis];
        proxy.box.max[axis] -= offset[axis];
      }
    }
  }

  void Add(bool is_static) {
    const Aabb box = RandomBox();
    const CollisionFilter filter = RandomFilter();
    Add(box, {filter, is_static, random_.Next()});
  }

  void Add(const Aabb& box, const ProxyOptions& options) {
    listed.push_back({proxies.Add(box, options), box, options});
  }

  void Remove() {
    const size_t place = random_.Below(listed.size());
    failed |= !proxies.Remove(listed[place].handle);
    gone.push_back(listed[place].handle);
    listed[place] = listed.back();
    listed.pop_back();
  }

  Aabb RandomBox() {
    switch (random_.Below(60)) {
      case 0:
        return BrokenBox();
      case 1:
        return {{-1e30F, -1e30F, -1e30F}, {1e30F, 1e30F, 0}};
      case 2:  // far away
        return {{1e30F, 1e30F, 1e30F}, {1e30F, 2e30F, 3e30F}};
      default:
        return BoxAt(random_.Below(8) == 0 ? 0 : random_.Between(0.1F, 0.9F));
    }
  }

  // Half of the center coordinates are integers, so that many are equal and faces touch.
  Aabb BoxAt(float half_extent) {
    Aabb box;
    for (int axis = 0; axis < 3; ++axis) {
      float center = random_.Between(0, world_);
      if (random_.Below(2) == 0) center = static_cast<float>(static_cast<int>(center));
      box.min[axis] = center - half_extent;
      box.max[axis] = center + half_extent;
    }
    return box;
  }

  CollisionFilter RandomFilter() {
    if (random_.Below(2) == 0) return {};
    return {uint32_t{1} << random_.Below(3), static_cast<uint32_t>(random_.Below(8))};
  }

  SequentialRandom& random() { return random_; }
  ListedProxy& Any() { return listed[random_.Below(listed.size())]; }

  ProxySet proxies;
  std::vector<ListedProxy> listed;
  std::vector<ProxyHandle> gone;
  bool failed = false;  // whether a call refused a valid handle

 private:
  Aabb BrokenBox() {
    Aabb box = BoxAt(0.5F);
    const size_t axis = random_.Below(3);
    switch (random_.Below(3)) {
      case 0:
        box.min[axis] = std::numeric_limits<float>::quiet_NaN();
        break;
      case 1:
        box.max[axis] = std::numeric_limits<float>::infinity();
        break;
      default:
        std::swap(box.min[axis], box.max[axis]);
    }
    return box;
  }

  Aabb Moved(const Aabb& box) {
    if (random_.Below(20) == 0) return RandomBox();
    Aabb moved = box;
    for (int axis = 0; axis < 3; ++axis) {
      const float step = 0.1F * random_.Symmetric();
      moved.min[axis] += step;
      moved.max[axis] += step;
    }
    return moved;
  }

  void MoveTo(ListedProxy& proxy, const Aabb& box) {
    proxy.box = box;
    failed |= !proxies.Move(proxy.handle, box);
  }

  SequentialRandom random_;
  float world_;
  std::vector<ProxyHandle> burst_;
};

// Returns the pairs of Resolve as handles. Sets `doubled` if a pair occurs twice or has a >= b.
inline ProxyPairs AsHandles(const ProxySet& proxies, std::span<const OverlapPair> pairs,
                            bool& doubled) {
  ProxyPairs handles;
  doubled = false;
  for (const OverlapPair& pair : pairs) {
    if (pair.a >= pair.b) doubled = true;
    if (!handles.insert({proxies.handle(pair.a), proxies.handle(pair.b)}).second) doubled = true;
  }
  return handles;
}

}  // namespace sweepstake::test_support
