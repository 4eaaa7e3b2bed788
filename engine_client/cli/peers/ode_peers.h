// ODE: its collision spaces (simple, sweep and prune, quadtree), on boxes in double
// precision.
#pragma once

#include "engine_client/cli/peers/peer.h"

namespace sweepstake::cli {

// Fills in the version and the kinds.
void AddOdePeers(PeerLibrary& library);

}  // namespace sweepstake::cli
