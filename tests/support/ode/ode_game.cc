#include "tests/support/ode/ode_game.h"

#include <array>
#include <bit>
#include <chrono>
#include <cmath>

namespace sweepstake::test_support {
namespace {

constexpr unsigned long kScenery = 2;  // category; bodies have 1

}  // namespace

OdeGameOptions OdePileOf(int body_count) {
  return {.pile_count = body_count, .half_width = std::max(2.0, std::sqrt(body_count / 4.0) / 2)};
}

// ODE counts its initializations, so each game can have its own.
OdeGame::OdeGame(const OdeGameOptions& options) : options_(options) {
  dInitODE2(0);
  dAllocateODEDataForThread(dAllocateMaskAll);
  world_ = dWorldCreate();
  space_ = options.make_space(nullptr);
  contacts_ = dJointGroupCreate(0);
  dWorldSetGravity(world_, 0, 0, -9.8);
  dWorldSetAutoDisableFlag(world_, 1);
  const double wall = -options.half_width;
  for (const auto& [x, y] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
    dGeomSetCategoryBits(Name(dCreatePlane(space_, x, y, 0, wall)), kScenery);
  }
  dGeomSetCategoryBits(Name(dCreatePlane(space_, 0, 0, 1, 0)), kScenery);
  AddScenery(options.scenery_count);
  const int across = std::max(1, static_cast<int>(options.half_width * 2 / 1.2) - 1);
  for (int i = 0; i < options.pile_count; ++i) {
    const int layer = i / (across * across);
    const auto at = [&](int cell) { return (cell - across / 2.0 + 0.5) * 1.2; };
    AddBody(at(i % across) + Random(-0.1, 0.1), at(i / across % across) + Random(-0.1, 0.1),
            1.5 + layer * 1.2);
  }
  for (int i = 0; i < options.chain_count; ++i) AddChain(i);
}

OdeGame::~OdeGame() {
  dJointGroupDestroy(contacts_);
  dSpaceDestroy(space_);  // also its geoms
  dWorldDestroy(world_);
  dCloseODE();
}

void OdeGame::Step(const Collide& collide) {
  if (options_.event_interval != 0 && step_count_ % options_.event_interval == 0) PlayEvent();
  near_.clear();
  const auto before = std::chrono::steady_clock::now();
  collide(&near_, [](void* near, dGeomID a, dGeomID b) {
    static_cast<std::vector<std::pair<dGeomID, dGeomID>>*>(near)->emplace_back(a, b);
  });
  const auto time = std::chrono::steady_clock::now() - before;
  collide_ns_ = static_cast<uint64_t>(std::chrono::nanoseconds(time).count());
  AddContacts();
  dRandSetSeed(
      static_cast<unsigned long>(step_count_));  // the solver shuffles by this one sequence
  dWorldQuickStep(world_, 1.0 / 60);
  dJointGroupEmpty(contacts_);
  ++step_count_;
  HashBodies();
}

OdeGame::Calls OdeGame::calls() const {
  Calls calls;
  for (const auto& [a, b] : near_) calls.emplace_back(IdOf(a), IdOf(b));
  return calls;
}

int OdeGame::sleeping_count() const {
  int count = 0;
  for (const dBodyID body : bodies_) count += dBodyIsEnabled(body) == 0 ? 1 : 0;
  return count;
}

int OdeGame::IdOf(dGeomID geom) {
  return static_cast<int>(reinterpret_cast<intptr_t>(dGeomGetData(geom)));
}

dGeomID OdeGame::Name(dGeomID geom) {
  // ODE's user pointer holds the id itself.
  // NOLINTNEXTLINE(performance-no-int-to-ptr)
  dGeomSetData(geom, reinterpret_cast<void*>(static_cast<intptr_t>(next_id_++)));
  return geom;
}

dGeomID OdeGame::AddShape() {
  switch (random_() % 3) {
    case 0:
      return Name(dCreateSphere(space_, Random(0.2, 0.5)));
    case 1:
      return Name(dCreateCapsule(space_, Random(0.15, 0.3), Random(0.2, 0.6)));
    default:
      break;
  }
  return Name(dCreateBox(space_, Random(0.3, 0.9), Random(0.3, 0.9), Random(0.3, 0.9)));
}

dBodyID OdeGame::AddBody(double x, double y, double z) {
  const dBodyID body = dBodyCreate(world_);
  dMass mass;
  dMassSetSphereTotal(&mass, 1, 0.4);
  dBodySetMass(body, &mass);
  dBodySetPosition(body, x, y, z);
  dGeomSetBody(AddShape(), body);
  if (random_() % 4 == 0) {  // a second geom, whose box overlaps the first
    const dGeomID second = AddShape();
    dGeomSetBody(second, body);
    dGeomSetOffsetPosition(second, 0.3, 0, 0);
  }
  bodies_.push_back(body);
  return body;
}

void OdeGame::AddChain(int index) {
  dBodyID before = nullptr;
  for (int link = 0; link < 6; ++link) {
    const double z = 3 + 0.9 * link;
    const dBodyID body = AddBody(-2 + 0.7 * index, 0, z);
    if (before != nullptr) {
      const dJointID joint = dJointCreateBall(world_, nullptr);
      dJointAttach(joint, before, body);
      dJointSetBallAnchor(joint, -2 + 0.7 * index, 0, z - 0.45);
    }
    before = body;
  }
}

void OdeGame::AddScenery(int count) {
  const double reach = options_.half_width;
  for (int i = 0; i < count; ++i) {
    const dGeomID geom = Name(dCreateBox(space_, Random(0.2, 1), Random(0.2, 1), Random(0.1, 0.4)));
    dGeomSetPosition(geom, Random(-reach, reach), Random(-reach, reach), 0.1);
    dGeomSetCategoryBits(geom, kScenery);
    dGeomSetCollideBits(geom, ~kScenery);
  }
}

void OdeGame::Destroy(dBodyID body) {
  while (const dGeomID geom = dBodyGetFirstGeom(body)) dGeomDestroy(geom);
  std::erase(bodies_, body);
  dBodyDestroy(body);
}

// Plays the next of the events: a body comes, the oldest goes, a geom is disabled or enabled, a
// geom collides with other categories, a body gets another geom, a body is pushed, a body stops.
void OdeGame::PlayEvent() {
  const double reach = options_.half_width / 2;
  const dGeomID geom = dBodyGetFirstGeom(RandomBody());
  switch (step_count_ / options_.event_interval % 8) {
    case 0:
      AddBody(Random(-reach, reach), Random(-reach, reach), 5);
      break;
    case 1:
      Destroy(bodies_.front());
      break;
    case 2:
      dGeomIsEnabled(geom) != 0 ? dGeomDisable(geom) : dGeomEnable(geom);
      break;
    case 3:
      dGeomSetCollideBits(geom, random_() % 2 == 0 ? ~0UL : kScenery);
      break;
    case 4:
      dGeomSetCategoryBits(geom, random_() % 2 == 0 ? 1 : 0);
      break;
    case 5: {
      const dBodyID body = dGeomGetBody(geom);
      dGeomDestroy(geom);
      dGeomSetBody(AddShape(), body);
      break;
    }
    case 6:
      dBodyEnable(dGeomGetBody(geom));
      dBodyAddForce(dGeomGetBody(geom), Random(-200, 200), Random(-200, 200), 400);
      break;
    default:
      dBodyDisable(dGeomGetBody(geom));
      break;
  }
}

void OdeGame::AddContacts() {
  std::array<dContact, 4> contacts = {};
  for (const auto& [a, b] : near_) {
    const dBodyID body_a = dGeomGetBody(a);
    const dBodyID body_b = dGeomGetBody(b);
    if (body_a == nullptr && body_b == nullptr) continue;
    if (body_a != nullptr && body_b != nullptr &&
        dAreConnectedExcluding(body_a, body_b, dJointTypeContact) != 0) {
      continue;
    }
    const int count = dCollide(a, b, contacts.size(), &contacts[0].geom, sizeof(dContact));
    contact_count_ += count;
    for (int i = 0; i < count; ++i) {
      dContact& contact = contacts[static_cast<size_t>(i)];
      contact.surface.mode = dContactApprox1;
      contact.surface.mu = 0.5;
      dJointAttach(dJointCreateContact(world_, contacts_, &contact), body_a, body_b);
    }
  }
}

void OdeGame::HashBodies() {
  for (const dBodyID body : bodies_) {
    Mix(static_cast<uint64_t>(dBodyIsEnabled(body)));
    for (const dReal* const values : {dBodyGetPosition(body), dBodyGetLinearVel(body),
                                      dBodyGetAngularVel(body), dBodyGetQuaternion(body)}) {
      for (int i = 0; i < 3; ++i) Mix(std::bit_cast<uint64_t>(double{values[i]}));
    }
  }
}

double OdeGame::Random(double low, double high) {
  constexpr double kRange = std::minstd_rand::max() - std::minstd_rand::min();
  return low + (high - low) * static_cast<double>(random_() - std::minstd_rand::min()) / kRange;
}

dBodyID OdeGame::RandomBody() { return bodies_[random_() % bodies_.size()]; }

}  // namespace sweepstake::test_support
