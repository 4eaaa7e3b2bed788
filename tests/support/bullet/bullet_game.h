// A game on a dynamics world of Bullet: the same steps for the same options, whatever the broad
// phase, so that broad phases can be compared by what becomes of the world.
//
// Not thread-safe. The broad phase is borrowed and must outlive the game. Lengths in metres; one
// step is 1/60 s.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <cstdint>
#include <deque>
#include <memory>
#include <random>
#include <span>
#include <vector>

#include "sweepstake/aabb.h"

namespace sweepstake::test_support {

// What is in the world besides the ground and its four walls.
struct BulletGameOptions {
  int stack_height = 0;  // boxes upon one another, a little askew
  int pile_count = 0;    // boxes, spheres and capsules that fall into a heap
  int chain_count = 0;   // of eight capsules each, joined at their ends like limbs
  int lift_count = 0;    // kinematic boxes that go up and down
  // A body comes in every so many steps, and then the oldest of `visitor_limit` leaves; 0: none.
  int visitor_interval = 0;
  int visitor_limit = 20;
  int blow_interval = 0;  // steps between two blows, which wake what sleeps; 0: none
  // Every so many steps some bodies collide with nothing for a sixth of a second; 0: none.
  int phase_interval = 0;
  int query_interval = 0;  // steps between two rays, sweeps and box queries; 0: none
  float half_width = 12;   // from the middle to a wall
  // Solves contacts in an order that does not depend on that of the pairs in the cache, but on the
  // proxies' ids alone.
  bool sorts_pairs = false;
};

// Returns a heap of bodies in a pit that holds about four layers of them.
BulletGameOptions PileOf(int body_count);

// A dynamics world that knows what its broad phase has cost.
class TimedWorld final : public btDiscreteDynamicsWorld {
 public:
  using btDiscreteDynamicsWorld::btDiscreteDynamicsWorld;

  void updateAabbs() override;
  void computeOverlappingPairs() override;

  // Returns the time of both since the world began, which includes that of the shapes to tell their
  // boxes.
  uint64_t broad_phase_ns() const { return broad_phase_ns_; }

 private:
  uint64_t broad_phase_ns_ = 0;
};

class BulletGame {
 public:
  BulletGame(btBroadphaseInterface& broad_phase, const BulletGameOptions& options);
  ~BulletGame();

  void Step();

  // Returns a number made of all bodies' places, velocities and states of sleep, of all that the
  // queries have found, and of the hashes of all steps before.
  uint64_t state_hash() const { return hash_; }
  int step_count() const { return step_count_; }
  int sleeping_count() const;
  TimedWorld& world() { return world_; }

  // Returns the boxes of the bodies as the broad phase has them, in the order of the world.
  std::span<const Aabb> boxes();

 private:
  btRigidBody& Add(btCollisionShape& shape, float mass, const btVector3& place);
  btRigidBody& AddLoose(const btVector3& place);
  void BuildGround();
  void BuildStack();
  void BuildPile();
  void BuildChain(int index);
  void BuildLifts();
  void Remove(btRigidBody& body);
  void MoveLifts();
  void LetVisitorsCome();
  void Blow();
  void Phase();
  void Query();
  void HashRay(const btVector3& from, const btVector3& to);
  void HashSweep(const btVector3& from, const btVector3& to);
  void HashBox(const btVector3& middle);
  void HashBodies();
  float Random(float low, float high);
  void Mix(uint64_t value) { hash_ = (hash_ ^ value) * 0x100000001b3; }
  void Mix(const btVector3& value);

  const BulletGameOptions options_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btSequentialImpulseConstraintSolver solver_;
  TimedWorld world_;
  btBoxShape ground_;
  btBoxShape wall_;
  btBoxShape box_{btVector3(0.5F, 0.5F, 0.5F)};
  btBoxShape plank_{btVector3(0.9F, 0.2F, 0.4F)};
  btSphereShape ball_{0.5F};
  btCapsuleShape limb_{0.2F, 0.6F};
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<std::unique_ptr<btTypedConstraint>> joints_;
  std::vector<btRigidBody*> lifts_;
  std::deque<btRigidBody*> visitors_;
  std::vector<Aabb> boxes_;
  std::minstd_rand random_{1};
  int next_id_ = 0;
  int step_count_ = 0;
  uint64_t hash_ = 0xcbf29ce484222325;
};

}  // namespace sweepstake::test_support
