// A game on a dynamics world of Bullet. The same options give the same steps with every broad
// phase, so that broad phases can be compared by the state of the world.
//
// Not thread-safe. The broad phase is borrowed and must outlive the game. Lengths are in metres;
// one step is 1/60 s.
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

// The content of the world in addition to the ground and its four walls.
struct BulletGameOptions {
  int stack_height = 0;  // boxes on top of each other, slightly shifted
  int pile_count = 0;    // boxes, spheres and capsules that fall on a heap
  int chain_count = 0;   // chains of eight capsules, joined at their ends
  int lift_count = 0;    // kinematic boxes that go up and down
  // Steps between two visitors; with more than `visitor_limit`, the oldest leaves. 0: no visitors.
  int visitor_interval = 0;
  int visitor_limit = 20;
  int blow_interval = 0;  // steps between blows, which wake bodies; 0: none
  // Steps after which some bodies collide with nothing for a sixth of a second; 0: none.
  int phase_interval = 0;
  int query_interval = 0;  // steps between queries (rays, sweeps, boxes); 0: none
  float half_width = 12;   // distance from the centre to a wall
  // Solves contacts in the order of the proxies' ids instead of the order of pairs in the cache.
  bool sorts_pairs = false;
};

// Returns options for a heap of bodies in a pit, about four layers deep.
BulletGameOptions PileOf(int body_count);

// A dynamics world that measures the time of its broad phase.
class TimedWorld final : public btDiscreteDynamicsWorld {
 public:
  using btDiscreteDynamicsWorld::btDiscreteDynamicsWorld;

  void updateAabbs() override;
  void computeOverlappingPairs() override;

  // Returns the time of updating boxes and finding pairs since the world was created. It includes
  // the time in which shapes compute their boxes.
  uint64_t broad_phase_ns() const { return broad_phase_ns_; }

 private:
  uint64_t broad_phase_ns_ = 0;
};

class BulletGame {
 public:
  BulletGame(btBroadphaseInterface& broad_phase, const BulletGameOptions& options);
  ~BulletGame();

  void Step();

  // Returns a hash of the places, velocities and sleep states of all bodies, of all query results,
  // and of the hashes of all former steps.
  uint64_t state_hash() const { return hash_; }
  int step_count() const { return step_count_; }
  int sleeping_count() const;
  TimedWorld& world() { return world_; }

  // Returns the bodies' boxes in the broad phase, in the order of the world.
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
