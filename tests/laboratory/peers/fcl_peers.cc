#include "tests/laboratory/peers/peer.h"

#include <fcl/broadphase/broadphase_SSaP.h>
#include <fcl/broadphase/broadphase_bruteforce.h>
#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/broadphase/broadphase_dynamic_AABB_tree_array.h>
#include <fcl/broadphase/broadphase_interval_tree.h>
#include <fcl/broadphase/broadphase_spatialhash.h>
#include <fcl/config.h>

#include <cmath>

namespace sweepstake::cli {
namespace {

using Object = fcl::CollisionObject<double>;
using CollisionSpace = fcl::BroadPhaseCollisionManager<double>;

// A collision shape without its own geometry; FCL uses only its box.
class BoxShape final : public fcl::CollisionGeometry<double> {
 public:
  void computeLocalAABB() override {}

  void Take(const Aabb& box, double margin) {
    box_ = box;
    aabb_local.min_ << box.min[0] - margin, box.min[1] - margin, box.min[2] - margin;
    aabb_local.max_ << box.max[0] + margin, box.max[1] + margin, box.max[2] + margin;
  }
  const Aabb& box() const { return box_; }

 private:
  Aabb box_;
};

struct Body {
  explicit Body(uint32_t index) : id(index), shape(std::make_shared<BoxShape>()), object(shape) {
    object.setUserData(this);
  }
  void Take(const Aabb& box, double margin) {
    shape->Take(box, margin);
    object.computeAABB();
  }

  uint32_t id;
  std::shared_ptr<BoxShape> shape;
  Object object;
};

bool Collect(Object* a, Object* b, void* out) {
  const auto& first = *static_cast<const Body*>(a->getUserData());
  const auto& second = *static_cast<const Body*>(b->getUserData());
  if (ValidBoxesOverlap(first.shape->box(), second.shape->box())) {
    AppendPair(*static_cast<PairBuffer*>(out), first.id, second.id);
  }
  return false;  // false makes FCL continue with the next pair
}

// Returns the edge length of a cell of the spatial hash: the mean of the boxes' longest edges.
// Twice this length was slower.
double CellEdge(std::span<const Aabb> boxes) {
  double sum = 0;
  for (const Aabb& box : boxes) {
    double longest = 0;
    for (int axis = 0; axis < 3; ++axis) {
      longest = std::max(longest, double{box.max[axis]} - double{box.min[axis]});
    }
    sum += longest;
  }
  return sum > 0 ? sum / static_cast<double>(boxes.size()) : 1;
}

// Some managers treat boxes as open at their faces, so every box is enlarged by this margin, about
// 500 times the rounding error of a world of this size.
double MarginFor(std::span<const Aabb> boxes) {
  const Aabb world = RoomyBounds(boxes);
  double farthest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    farthest =
        std::max({farthest, std::abs(double{world.min[axis]}), std::abs(double{world.max[axis]})});
  }
  return 1e-13 * farthest;
}

template <typename T>
std::unique_ptr<CollisionSpace> MakeSpace(std::span<const Aabb>) {
  return std::make_unique<T>();
}

std::unique_ptr<CollisionSpace> MakeHash(std::span<const Aabb> boxes) {
  const Aabb world = RoomyBounds(boxes);
  return std::make_unique<fcl::SpatialHashingCollisionManager<double>>(
      CellEdge(boxes), fcl::Vector3d(world.min[0], world.min[1], world.min[2]),
      fcl::Vector3d(world.max[0], world.max[1], world.max[2]),
      static_cast<unsigned>(std::max<size_t>(1000, 2 * boxes.size())));
}

class FclPeer final : public Peer {
 public:
  using MakeManager = std::unique_ptr<CollisionSpace> (*)(std::span<const Aabb> boxes);

  FclPeer(std::string_view name, MakeManager make) : Peer(name), make_(make) {}

  void DoBuild(std::span<const Aabb> boxes) override {
    manager_.reset();
    bodies_.clear();
    margin_ = MarginFor(boxes);
    std::vector<Object*> objects;
    for (const Aabb& box : boxes) {
      bodies_.push_back(std::make_unique<Body>(static_cast<uint32_t>(bodies_.size())));
      bodies_.back()->Take(box, margin_);
      objects.push_back(&bodies_.back()->object);
    }
    manager_ = make_(boxes);
    manager_->registerObjects(objects);
    manager_->setup();
  }

  // Registers all objects again if their number has changed: this is faster than adding or removing
  // many one by one.
  void DoUpdate(std::span<const Aabb> boxes) override {
    if (boxes.size() != bodies_.size()) return DoBuild(boxes);
    for (size_t i = 0; i < boxes.size(); ++i) bodies_[i]->Take(boxes[i], margin_);
    manager_->update();
  }

  void DoFindPairs(PairBuffer& out) override {
    if (!bodies_.empty()) manager_->collide(&out, Collect);
  }

 private:
  MakeManager make_;
  double margin_ = 0;
  std::vector<std::unique_ptr<Body>> bodies_;
  std::unique_ptr<CollisionSpace> manager_;
};

}  // namespace

void AddFclPeers(PeerLibrary& library) {
  // The list below leaves out SaPCollisionManager: in version 0.7.0 its update does not end if
  // boxes coincide. Otherwise it takes longer than the update of Bullet's sweep.
  using S = double;
  constexpr uint32_t kMaxInSweep = 30'000;  // more objects take too long
  library.version = FCL_VERSION;
  library.kinds = {
      {"FclBruteForce", "BruteForce", 20'000, false,
       MakePeer<FclPeer, MakeSpace<fcl::NaiveCollisionManager<S>>>},
      {"FclSpatialHash", "Grid", 200'000, false, MakePeer<FclPeer, MakeHash>},
      {"FclSSaP", "SAP", kMaxInSweep, false,
       MakePeer<FclPeer, MakeSpace<fcl::SSaPCollisionManager<S>>>},
      {"FclDynamicTree", "DBVT", 200'000, false,
       MakePeer<FclPeer, MakeSpace<fcl::DynamicAABBTreeCollisionManager<S>>>},
      {"FclDynamicTreeArray", "DBVT", 200'000, false,
       MakePeer<FclPeer, MakeSpace<fcl::DynamicAABBTreeCollisionManager_Array<S>>>},
      {"FclIntervalTree", "SAP", kMaxInSweep, false,
       MakePeer<FclPeer, MakeSpace<fcl::IntervalTreeCollisionManager<S>>>},
  };
}

}  // namespace sweepstake::cli
