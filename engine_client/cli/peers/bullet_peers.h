// Bullet: the dynamic tree (btDbvtBroadphase), collided at once and deferred, and the sweep along
// three sorted axes (btAxisSweep3 and bt32BitAxisSweep3).
#pragma once

#include "engine_client/cli/peers/peer.h"

namespace sweepstake::cli {

// Fills in the version and the kinds.
void AddBulletPeers(PeerLibrary& library);

}  // namespace sweepstake::cli
