// Lists the broad phases of other libraries that this build has. Thread-safe.
#pragma once

#include <vector>

#include "tests/laboratory/peers/peer.h"

namespace sweepstake::cli {

// Returns all known libraries in a fixed order, including those that this build leaves out.
std::vector<PeerLibrary> PeerLibraries();

// Each function fills in the version and the kinds of its library and is defined in that library's
// file. If the build leaves a library out, CMakeLists.txt generates a function that fills in
// nothing.
//
// Bullet: the dynamic tree (btDbvtBroadphase), collided at once and deferred, and the sweep along
// three sorted axes (btAxisSweep3 and bt32BitAxisSweep3).
void AddBulletPeers(PeerLibrary& library);
// FCL: its broad-phase managers, in double precision.
void AddFclPeers(PeerLibrary& library);
// ODE: its collision spaces (simple, sweep and prune, quadtree), on boxes in double precision.
void AddOdePeers(PeerLibrary& library);
// Embree: rtcCollide of a scene of user geometry with itself. Its BVH is rebuilt or refitted every
// frame.
void AddEmbreePeers(PeerLibrary& library);
// Boost.Geometry: an R-tree that is packed again every frame, and a query per box.
void AddBoostPeers(PeerLibrary& library);
// CGAL: box_self_intersection_d, a streamed segment tree that scans where few boxes are left.
void AddCgalPeers(PeerLibrary& library);

}  // namespace sweepstake::cli
