#include "tests/laboratory/peers/peer.h"

#include <ode/ode.h>

#include <cmath>

namespace sweepstake::cli {
namespace {

// Initializes ODE for one peer. ODE counts its initializations, so each peer can have its own
// session.
class OdeSession {
 public:
  OdeSession() {
    dInitODE2(0);
    dAllocateODEDataForThread(dAllocateMaskAll);
  }
  ~OdeSession() { dCloseODE(); }
  OdeSession(const OdeSession&) = delete;
  OdeSession& operator=(const OdeSession&) = delete;
};

// Sets the box of a geom. The centre and the edges of a float box are exact in double, and so is
// the box that ODE computes from them, unless its coordinates differ by a factor above 2^28. ODE
// ignores boxes whose edges are all zero, so edges have a minimum length.
void Take(dGeomID geom, const Aabb& box) {
  dReal edge[3];
  dReal centre[3];
  for (int axis = 0; axis < 3; ++axis) {
    edge[axis] = std::max(dReal{box.max[axis]} - dReal{box.min[axis]}, dReal{1e-300});
    centre[axis] = (dReal{box.max[axis]} + dReal{box.min[axis]}) / 2;
  }
  dGeomBoxSetLengths(geom, edge[0], edge[1], edge[2]);
  dGeomSetPosition(geom, centre[0], centre[1], centre[2]);
}

uint32_t IdOf(dGeomID geom) {
  return static_cast<uint32_t>(reinterpret_cast<size_t>(dGeomGetData(geom)));
}

dSpaceID MakeSimple(std::span<const Aabb>) { return dSimpleSpaceCreate(nullptr); }

dSpaceID MakeSweep(std::span<const Aabb>) {
  return dSweepAndPruneSpaceCreate(nullptr, dSAP_AXES_XYZ);
}

// Chooses the depth so that a leaf holds about one object: one level per factor of four in the
// object count.
dSpaceID MakeQuadtree(std::span<const Aabb> boxes) {
  const Aabb world = RoomyBounds(boxes);
  dVector3 centre = {0, 0, 0, 0};
  dVector3 half = {0, 0, 0, 0};
  for (int axis = 0; axis < 3; ++axis) {
    centre[axis] = (dReal{world.min[axis]} + dReal{world.max[axis]}) / 2;
    half[axis] = (dReal{world.max[axis]} - dReal{world.min[axis]}) / 2;
  }
  const auto count = static_cast<double>(std::max<size_t>(boxes.size(), 4));
  const int depth = std::clamp(static_cast<int>(std::log2(count) / 2), 1, 8);
  return dQuadTreeSpaceCreate(nullptr, centre, half, depth);
}

class OdePeer final : public Peer {
 public:
  using MakeSpace = dSpaceID (*)(std::span<const Aabb> boxes);

  OdePeer(std::string_view name, MakeSpace make) : Peer(name), make_(make) {}
  ~OdePeer() override { Discard(); }

  void DoBuild(std::span<const Aabb> boxes) override {
    Discard();
    space_ = make_(boxes);
    for (const Aabb& box : boxes) Add(box);
  }

  void DoUpdate(std::span<const Aabb> boxes) override {
    while (geoms_.size() > boxes.size()) {
      dGeomDestroy(geoms_.back());
      geoms_.pop_back();
    }
    for (size_t i = 0; i < geoms_.size(); ++i) Take(geoms_[i], boxes[i]);
    for (const Aabb& box : boxes.subspan(geoms_.size())) Add(box);
  }

  // ODE compares the exact boxes before it calls the function with a pair.
  void DoFindPairs(PairBuffer& out) override {
    dSpaceCollide(space_, &out, [](void* pairs, dGeomID a, dGeomID b) {
      AppendPair(*static_cast<PairBuffer*>(pairs), IdOf(a), IdOf(b));
    });
  }

 private:
  void Add(const Aabb& box) {
    const dGeomID geom = dCreateBox(nullptr, 1, 1, 1);
    // ODE's user pointer holds the id itself.
    // NOLINTNEXTLINE(performance-no-int-to-ptr)
    dGeomSetData(geom, reinterpret_cast<void*>(geoms_.size()));
    Take(geom, box);
    dSpaceAdd(space_, geom);
    geoms_.push_back(geom);
  }

  // Destroying the space also destroys its geoms.
  void Discard() {
    if (space_ != nullptr) dSpaceDestroy(space_);
    space_ = nullptr;
    geoms_.clear();
  }

  OdeSession session_;
  MakeSpace make_;
  dSpaceID space_ = nullptr;
  std::vector<dGeomID> geoms_;
};

}  // namespace

void AddOdePeers(PeerLibrary& library) {
  library.version = SWEEPSTAKE_ODE_VERSION;  // ODE's headers have no version number
  // dHashSpace is left out: version 0.16.2 misses pairs (one in frame 4 of 400 objects of the scene
  // spawning).
  library.kinds = {
      {"OdeSimpleSpace", "BruteForce", 20'000, false, MakePeer<OdePeer, MakeSimple>},
      {"OdeSweepSpace", "SAP", 30'000, false, MakePeer<OdePeer, MakeSweep>},
      {"OdeQuadtreeSpace", "DBVT", 30'000, false, MakePeer<OdePeer, MakeQuadtree>},
  };
}

}  // namespace sweepstake::cli
