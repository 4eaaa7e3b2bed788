// A game on a world of ODE. The same options and the same near pairs give the same steps, so that
// broad phases can be compared by the state of the world.
//
// Not thread-safe. Lengths are in metres; one step is 1/60 s.
#pragma once

#include <ode/ode.h>

#include <cstdint>
#include <deque>
#include <functional>
#include <random>
#include <utility>
#include <vector>

namespace sweepstake::test_support {

// The content of the world in addition to the ground and its four walls, which are planes.
struct OdeGameOptions {
  int pile_count = 0;      // bodies of one or two geoms that fall on a heap
  int chain_count = 0;     // chains of six capsules, joined by ball joints
  int scenery_count = 0;   // boxes without body on the ground, which meet bodies only
  int event_interval = 0;  // steps between events, see OdeGame::PlayEvent; 0: none
  double half_width = 6;   // distance from the centre to a wall
  dSpaceID (*make_space)(dSpaceID parent) = dSimpleSpaceCreate;
};

// Returns options for a heap of bodies in a pit, about four layers deep.
OdeGameOptions OdePileOf(int body_count);

class OdeGame {
 public:
  // Calls the callback for the near pairs of the game's space, as dSpaceCollide.
  using Collide = std::function<void(void* data, dNearCallback* callback)>;
  // The ids of the geoms of each call of the callback, in its order.
  using Calls = std::vector<std::pair<int, int>>;

  explicit OdeGame(const OdeGameOptions& options);
  ~OdeGame();
  OdeGame(const OdeGame&) = delete;
  OdeGame& operator=(const OdeGame&) = delete;

  void Step(const Collide& collide);

  // Returns the id of a geom: how many geoms the game made before it.
  static int IdOf(dGeomID geom);

  dSpaceID space() const { return space_; }
  // Returns the calls of the latest step.
  Calls calls() const;
  // Returns the time of the latest call of Collide. The callback only stores the pairs, so this is
  // the time of the broad phase alone.
  uint64_t collide_ns() const { return collide_ns_; }
  int contact_count() const { return contact_count_; }  // the sum over all steps
  int sleeping_count() const;
  int geom_count() const { return dSpaceGetNumGeoms(space_); }
  // Returns a hash of the places, velocities and sleep states of all bodies in all steps.
  uint64_t state_hash() const { return hash_; }

 private:
  dGeomID Name(dGeomID geom);
  dBodyID AddBody(double x, double y, double z);
  dGeomID AddShape();
  void AddChain(int index);
  void AddScenery(int count);
  void Destroy(dBodyID body);
  void PlayEvent();
  void AddContacts();
  void HashBodies();
  double Random(double low, double high);
  dBodyID RandomBody();
  void Mix(uint64_t value) { hash_ = (hash_ ^ value) * 0x100000001b3; }

  const OdeGameOptions options_;
  dWorldID world_;
  dSpaceID space_;
  dJointGroupID contacts_;
  std::deque<dBodyID> bodies_;
  std::vector<std::pair<dGeomID, dGeomID>> near_;
  std::minstd_rand random_{1};
  int next_id_ = 0;
  int step_count_ = 0;
  int contact_count_ = 0;
  uint64_t collide_ns_ = 0;
  uint64_t hash_ = 0xcbf29ce484222325;
};

}  // namespace sweepstake::test_support
