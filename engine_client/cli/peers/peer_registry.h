// Which peers this build has. Thread-safe.
#pragma once

#include <vector>

#include "engine_client/cli/peers/peer.h"

namespace sweepstake::cli {

// All libraries that are known, those that were left out included: Bullet, FCL, ODE, Embree,
// Boost.Geometry, CGAL.
std::vector<PeerLibrary> PeerLibraries();

}  // namespace sweepstake::cli
