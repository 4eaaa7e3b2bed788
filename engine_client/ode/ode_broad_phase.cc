#include "sweepstake/ode.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "engine_client/broad_phase/host/float_environment.h"

namespace sweepstake {
namespace {

// A geom sleeps after its box was the same this number of times in a row. bullet_broad_phase.cc
// has the reason for the number.
constexpr uint32_t kRestCount = 30;

// Returns a valid box for the search from bounds that may be infinite, inverted or NaN. Boxes that
// overlap in ODE overlap here too, because rounding does not change the order of coordinates. ODE
// treats NaN like infinity, because no comparison with NaN separates two boxes.
Aabb BoxOf(const std::array<dReal, 6>& bounds) {
  constexpr dReal kMost = std::numeric_limits<float>::max();
  Aabb box;
  for (size_t axis = 0; axis < 3; ++axis) {
    const auto [low, high] = std::minmax(bounds[2 * axis], bounds[2 * axis + 1]);
    box.min[axis] = static_cast<float>(low > -kMost ? std::min(low, kMost) : -kMost);
    box.max[axis] = static_cast<float>(high < kMost ? std::max(high, -kMost) : kMost);
  }
  return box;
}

// ODE ignores shapes of zero size, as if they were disabled.
bool HasZeroSize(dGeomID geom) {
  dVector3 size = {1, 1, 1, 1};
  switch (dGeomGetClass(geom)) {
    case dSphereClass:
      size[0] = dGeomSphereGetRadius(geom);
      break;
    case dBoxClass:
      dGeomBoxGetLengths(geom, size);
      break;
    case dCapsuleClass:
      dGeomCapsuleGetParams(geom, &size[0], &size[3]);
      break;
    case dCylinderClass:
      dGeomCylinderGetParams(geom, &size[0], &size[1]);
      break;
    default:
      break;
  }
  return size[0] == 0 || size[1] == 0 || size[2] == 0;
}

dGeomID AsGeom(dSpaceID space) { return reinterpret_cast<dGeomID>(space); }

// dSpaceGetGeom ends the program for a quadtree. Its geoms are therefore listed by a collision with
// a tilted plane, whose box is infinite. Returns null for other spaces.
dGeomID PlaneForQuadTree(dSpaceID space) {
  const bool is_quad_tree = dGeomGetClass(AsGeom(space)) == dQuadTreeSpaceClass;
  return is_quad_tree ? dCreatePlane(nullptr, 0.6, 0, 0.8, 0) : nullptr;
}

}  // namespace

OdeBroadPhase::OdeBroadPhase(AdaptiveBroadPhase& search, dSpaceID space, Executor* executor)
    : search_(search),
      space_(space),
      everywhere_(PlaneForQuadTree(space)),
      proxies_({.executor = executor}) {}

void OdeBroadPhase::Collide(void* data, dNearCallback* callback) {
  dSpaceClean(space_);  // computes boxes in the game's environment, as dSpaceCollide does
  Search();
  for (const auto& [first, second] : pairs_) {
    callback(data, geoms_[order_[first]].geom, geoms_[order_[second]].geom);
  }
}

void OdeBroadPhase::Search() {
  const FloatEnvironmentScope environment;
  ReadGeoms();
  const auto found = search_.FindPairs(proxies_);
  if (search_.pairs_exceeded()) {
    AddPreviousPairs(std::exchange(pairs_, {}));
  } else {
    pairs_.clear();
    for (const auto& [a, b] : found) AddPair(a, b);
  }
  sorter_.Sort(pairs_);
}

// Adds the geoms with these ids to the pairs if they are a pair.
void OdeBroadPhase::AddPair(uint32_t a, uint32_t b) {
  if (!IsPair(geoms_[a], geoms_[b])) return;
  const auto [first, second] = std::minmax(geoms_[a].place, geoms_[b].place);
  pairs_.push_back({first, second});
}

// Adds the pairs of the previous search, of those geoms that are still in the space.
void OdeBroadPhase::AddPreviousPairs(const std::vector<OverlapPair>& pairs) {
  const auto is_present = [&](uint32_t id) {
    return id < geoms_.size() && geoms_[id].geom != nullptr;
  };
  for (const auto& [first, second] : pairs) {
    const uint32_t a = last_order_[first];
    const uint32_t b = last_order_[second];
    if (is_present(a) && is_present(b)) AddPair(a, b);
  }
}

// Decides as ODE's function collideAABBs. The boxes of the search are rounded to float, and
// the filter of ProxySet is stricter, so it is not used.
bool OdeBroadPhase::IsPair(const Geom& a, const Geom& b) {
  for (size_t min = 0, max = 1; max < a.bounds.size(); min += 2, max += 2) {
    if (a.bounds[min] > b.bounds[max] || a.bounds[max] < b.bounds[min]) return false;
  }
  const dBodyID body = dGeomGetBody(a.geom);
  if (body != nullptr && body == dGeomGetBody(b.geom)) return false;
  return (dGeomGetCategoryBits(a.geom) & dGeomGetCollideBits(b.geom)) != 0 ||
         (dGeomGetCategoryBits(b.geom) & dGeomGetCollideBits(a.geom)) != 0;
}

// Lists the geoms of the space in its order. The callback does not allocate: ODE would keep the
// space locked if it threw.
void OdeBroadPhase::ListGeoms() {
  const int geom_count = dSpaceGetNumGeoms(space_);
  listed_.clear();
  listed_.reserve(static_cast<size_t>(geom_count));
  if (everywhere_ == nullptr) {
    for (int i = 0; i < geom_count; ++i) listed_.push_back(dSpaceGetGeom(space_, i));
    return;
  }
  dSpaceCollide2(everywhere_.get(), AsGeom(space_), this, [](void* self, dGeomID a, dGeomID b) {
    auto& own = *static_cast<OdeBroadPhase*>(self);
    own.listed_.push_back(a == own.everywhere_.get() ? b : a);
  });
}

// Reads the list of the space. ODE moves the geoms that have moved to the front, so it often has
// the same order as in the previous search; a geom is first looked for behind its predecessor.
void OdeBroadPhase::ReadGeoms() {
  ListGeoms();
  last_order_.swap(order_);
  order_.clear();
  uint32_t next = 0;
  for (const dGeomID geom : listed_) {
    if (dGeomIsEnabled(geom) == 0 || HasZeroSize(geom)) continue;
    const bool is_next = next < last_order_.size() && geoms_[last_order_[next]].geom == geom;
    const uint32_t id = is_next ? last_order_[next] : IdOf(geom);
    next = geoms_[id].place + 1;  // 0 behind a new geom, which is often at the front
    geoms_[id].place = static_cast<uint32_t>(order_.size());
    order_.push_back(id);
    ReadBox(geoms_[id]);
  }
  if (order_.size() < ids_.size()) RemoveAbsent();
}

// Returns the id of the geom's proxy. ODE may give a new geom the address of a destroyed one; it
// then also gets its proxy.
uint32_t OdeBroadPhase::IdOf(dGeomID geom) {
  const auto [entry, is_new] = ids_.try_emplace(geom);
  if (is_new) {
    const ProxyHandle proxy = proxies_.Add({});  // zeros, like Geom::bounds
    if (proxy.index == geoms_.size()) geoms_.emplace_back();
    geoms_[proxy.index].geom = geom;
    geoms_[proxy.index].proxy = proxy;
    entry->second = proxy.index;
  }
  return entry->second;
}

void OdeBroadPhase::ReadBox(Geom& geom) {
  const Bounds before = geom.bounds;
  dGeomGetAABB(geom.geom, geom.bounds.data());
  if (geom.bounds != before) {
    proxies_.Move(geom.proxy, BoxOf(geom.bounds));  // also wakes it
    geom.rest_count = 0;
  } else if (geom.rest_count < kRestCount && ++geom.rest_count == kRestCount) {
    proxies_.SetSleeping(geom.proxy, true);
  }
}

// Removes the geoms that the previous search found in the list and this one did not.
void OdeBroadPhase::RemoveAbsent() {
  for (const uint32_t id : last_order_) {
    Geom& geom = geoms_[id];
    const bool is_present = geom.place < order_.size() && order_[geom.place] == id;
    if (is_present) continue;
    ids_.erase(geom.geom);
    proxies_.Remove(geom.proxy);
    geom = {};
  }
  while (!geoms_.empty() && geoms_.back().geom == nullptr) geoms_.pop_back();
}

}  // namespace sweepstake
