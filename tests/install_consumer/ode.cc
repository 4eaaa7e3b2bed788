// A C++ game whose ball falls on the ground, with Sweepstake as the broad phase of ODE.
#include "sweepstake/ode.h"

#include <ode/ode.h>

#include "sweepstake/adaptive_broad_phase.h"

namespace {

struct Game {
  dWorldID world;
  dJointGroupID contacts;
};

void NearCallback(void* data, dGeomID a, dGeomID b) {
  const Game& game = *static_cast<const Game*>(data);
  dContact contact = {};
  if (dCollide(a, b, 1, &contact.geom, sizeof(contact)) == 0) return;
  const dJointID joint = dJointCreateContact(game.world, game.contacts, &contact);
  dJointAttach(joint, dGeomGetBody(a), dGeomGetBody(b));
}

}  // namespace

int main() {
  dInitODE2(0);
  const dSpaceID space = dHashSpaceCreate(nullptr);
  Game game = {dWorldCreate(), dJointGroupCreate(0)};
  dWorldSetGravity(game.world, 0, 0, -10);
  dCreatePlane(space, 0, 0, 1, 0);
  const dBodyID ball = dBodyCreate(game.world);
  dGeomSetBody(dCreateSphere(space, 0.5), ball);
  dBodySetPosition(ball, 0, 0, 2);

  auto search = sweepstake::AdaptiveBroadPhase::Create({}, nullptr);
  if (!search.ok()) return 1;
  sweepstake::OdeBroadPhase broad_phase(**search, space);
  for (int step = 0; step < 120; ++step) {
    (*search)->BeginFrame();
    broad_phase.Collide(&game, &NearCallback);
    dWorldQuickStep(game.world, 1.0 / 60);
    dJointGroupEmpty(game.contacts);
    (*search)->EndFrame({.frame_time_ns = 16'666'667});
  }
  const dReal height = dBodyGetPosition(ball)[2];
  return height > 0.4 && height < 0.6 ? 0 : 1;
}
