// A C++ game whose ball falls on the ground, with Sweepstake as the broad phase of Bullet.
#include "sweepstake/bullet.h"

#include <btBulletDynamicsCommon.h>

#include "sweepstake/adaptive_broad_phase.h"

int main() {
  auto search = sweepstake::AdaptiveBroadPhase::Create({}, nullptr);
  if (!search.ok()) return 1;
  sweepstake::BulletBroadPhase broad_phase(**search);
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world(&dispatcher, &broad_phase, &solver, &configuration);
  btBoxShape ground_shape(btVector3(10, 1, 10));
  btSphereShape ball_shape(0.5F);
  btRigidBody ground(0, nullptr, &ground_shape);
  btRigidBody ball(1, nullptr, &ball_shape);
  ground.translate(btVector3(0, -1, 0));
  ball.translate(btVector3(0, 2, 0));
  world.addRigidBody(&ground);
  world.addRigidBody(&ball);
  for (int step = 0; step < 240; ++step) {
    (*search)->BeginFrame();
    world.stepSimulation(1.0F / 60, 0);
    (*search)->EndFrame({.frame_time_ns = 16'666'667});
  }
  const float height = ball.getWorldTransform().getOrigin().y();
  world.removeRigidBody(&ball);
  world.removeRigidBody(&ground);
  return height > 0.4F && height < 0.6F ? 0 : 1;
}
