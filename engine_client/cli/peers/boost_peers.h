// Boost.Geometry: an R-tree packed anew every frame, and a query per box.
#pragma once

#include "engine_client/cli/peers/peer.h"

namespace sweepstake::cli {

// Fills in the version and the kinds.
void AddBoostPeers(PeerLibrary& library);

}  // namespace sweepstake::cli
