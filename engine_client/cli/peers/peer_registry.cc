#include "engine_client/cli/peers/peer_registry.h"

namespace sweepstake::cli {

std::vector<PeerLibrary> PeerLibraries() {
  std::vector<PeerLibrary> libraries = {
      {"Bullet", "libbullet-dev", "zlib", "", {}},
      {"FCL", "libfcl-dev", "BSD-3-Clause", "", {}},
      {"ODE", "libode-dev", "BSD-3-Clause or LGPL-2.1+", "", {}},
      {"Embree", "libembree-dev", "Apache-2.0", "", {}},
      {"Boost.Geometry", "libboost-dev", "BSL-1.0", "", {}},
      {"CGAL", "libcgal-dev", "GPL-3.0+", "", {}},
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
