// FCL: its broad-phase managers, in double precision.
#pragma once

#include "engine_client/cli/peers/peer.h"

namespace sweepstake::cli {

// Fills in the version and the kinds.
void AddFclPeers(PeerLibrary& library);

}  // namespace sweepstake::cli
