#include "tests/laboratory/peers/peer.h"

namespace sweepstake::cli {

std::vector<PeerLibrary> PeerLibraries() {
  std::vector<PeerLibrary> libraries = {
      {"Bullet", "libbullet-dev", "", {}},
      {"FCL", "libfcl-dev", "", {}},
      {"ODE", "libode-dev", "", {}},
      {"Embree", "libembree-dev", "", {}},
      {"Boost.Geometry", "libboost-dev", "", {}},
      {"CGAL", "libcgal-dev", "", {}},
  };
  AddBulletPeers(libraries[0]);
  AddFclPeers(libraries[1]);
  AddOdePeers(libraries[2]);
  AddEmbreePeers(libraries[3]);
  AddBoostPeers(libraries[4]);
  AddCgalPeers(libraries[5]);
  return libraries;
}

Aabb RoomyBounds(std::span<const Aabb> boxes) {
  if (boxes.empty()) return {{0, 0, 0}, {1, 1, 1}};
  Aabb bounds = boxes.front();
  for (const Aabb& box : boxes) {
    for (int axis = 0; axis < 3; ++axis) {
      bounds.min[axis] = std::min(bounds.min[axis], box.min[axis]);
      bounds.max[axis] = std::max(bounds.max[axis], box.max[axis]);
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    const float room = (bounds.max[axis] - bounds.min[axis]) / 4;
    bounds.min[axis] -= room;
    bounds.max[axis] += room;
  }
  return bounds;
}

}  // namespace sweepstake::cli
