// Embree: rtcCollide of a scene of user geometry with itself, its BVH built anew
// every frame, or refitted.
#pragma once

#include "engine_client/cli/peers/peer.h"

namespace sweepstake::cli {

// Fills in the version and the kinds.
void AddEmbreePeers(PeerLibrary& library);

}  // namespace sweepstake::cli
