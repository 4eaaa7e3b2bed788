// CGAL: box_self_intersection_d, a streamed segment tree that scans where few boxes are left.
#pragma once

#include "engine_client/cli/peers/peer.h"

namespace sweepstake::cli {

// Fills in the version and the kinds.
void AddCgalPeers(PeerLibrary& library);

}  // namespace sweepstake::cli
