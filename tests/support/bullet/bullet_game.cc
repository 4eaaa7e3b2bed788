#include "tests/support/bullet/bullet_game.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <iterator>

namespace sweepstake::test_support {
namespace {

constexpr float kStepS = 1.0F / 60;
constexpr float kWallHeight = 4;
constexpr float kGap = 1.3F;  // between the bodies of the pile before they fall

btTransform At(const btVector3& place, const btQuaternion& turn = btQuaternion::getIdentity()) {
  return btTransform(turn, place);
}

template <typename Call>
uint64_t TimeOf(const Call& call) {
  const auto start = std::chrono::steady_clock::now();
  call();
  return static_cast<uint64_t>(
      std::chrono::nanoseconds(std::chrono::steady_clock::now() - start).count());
}

// Collects the bodies whose own boxes overlap the query's box; a broad phase may report more.
class BodiesInBox final : public btBroadphaseAabbCallback {
 public:
  BodiesInBox(const btVector3& min, const btVector3& max) : min_(min), max_(max) {}

  bool process(const btBroadphaseProxy* proxy) override {
    if (TestAabbAgainstAabb2(min_, max_, proxy->m_aabbMin, proxy->m_aabbMax)) {
      ids_.push_back(static_cast<btCollisionObject*>(proxy->m_clientObject)->getUserIndex());
    }
    return true;
  }

  std::vector<int> SortedIds() {
    std::sort(ids_.begin(), ids_.end());
    return ids_;
  }

 private:
  btVector3 min_;
  btVector3 max_;
  std::vector<int> ids_;
};

}  // namespace

BulletGameOptions PileOf(int body_count) {
  return {.pile_count = body_count,
          .half_width = std::max(3.0F, 0.25F * std::sqrt(static_cast<float>(body_count)))};
}

void TimedWorld::updateAabbs() {
  broad_phase_ns_ += TimeOf([this] { btDiscreteDynamicsWorld::updateAabbs(); });
}

void TimedWorld::computeOverlappingPairs() {
  broad_phase_ns_ += TimeOf([this] { btDiscreteDynamicsWorld::computeOverlappingPairs(); });
}

BulletGame::BulletGame(btBroadphaseInterface& broad_phase, const BulletGameOptions& options)
    : options_(options),
      world_(&dispatcher_, &broad_phase, &solver_, &configuration_),
      ground_({options.half_width + 1, 1, options.half_width + 1}),
      wall_({options.half_width + 1, kWallHeight, 0.5F}) {
  world_.getDispatchInfo().m_deterministicOverlappingPairs = options.sorts_pairs;
  BuildGround();
  BuildStack();
  BuildPile();
  for (int i = 0; i < options_.chain_count; ++i) BuildChain(i);
  BuildLifts();
}

BulletGame::~BulletGame() {
  for (const auto& joint : joints_) world_.removeConstraint(joint.get());
  for (const auto& body : bodies_) world_.removeRigidBody(body.get());
}

void BulletGame::Step() {
  MoveLifts();
  LetVisitorsCome();
  if (options_.blow_interval > 0 && step_count_ % options_.blow_interval == 0) Blow();
  if (options_.phase_interval > 0) Phase();
  if (options_.query_interval > 0 && step_count_ % options_.query_interval == 0) Query();
  world_.stepSimulation(kStepS, /*maxSubSteps=*/0, kStepS);
  HashBodies();
  ++step_count_;
}

int BulletGame::sleeping_count() const {
  return static_cast<int>(std::count_if(bodies_.begin(), bodies_.end(), [](const auto& body) {
    return body->getActivationState() == ISLAND_SLEEPING && !body->isStaticObject();
  }));
}

std::span<const Aabb> BulletGame::boxes() {
  boxes_.clear();
  for (int i = 0; i < world_.getNumCollisionObjects(); ++i) {
    const btBroadphaseProxy* const proxy =
        world_.getCollisionObjectArray()[i]->getBroadphaseHandle();
    const btVector3& min = proxy->m_aabbMin;
    const btVector3& max = proxy->m_aabbMax;
    boxes_.push_back({{min.x(), min.y(), min.z()}, {max.x(), max.y(), max.z()}});
  }
  return boxes_;
}

btRigidBody& BulletGame::Add(btCollisionShape& shape, float mass, const btVector3& place) {
  btVector3 inertia(0, 0, 0);
  if (mass > 0) shape.calculateLocalInertia(mass, inertia);
  btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, &shape, inertia);
  info.m_startWorldTransform = At(place);
  bodies_.push_back(std::make_unique<btRigidBody>(info));
  bodies_.back()->setUserIndex(next_id_++);
  world_.addRigidBody(bodies_.back().get());
  return *bodies_.back();
}

btRigidBody& BulletGame::AddLoose(const btVector3& place) {
  btCollisionShape* const shapes[] = {&box_, &ball_, &limb_, &plank_};
  return Add(*shapes[next_id_ % std::size(shapes)], 1, place);
}

void BulletGame::BuildGround() {
  Add(ground_, 0, {0, -1, 0});
  const float edge = options_.half_width + 0.5F;
  for (const float side : {-edge, edge}) {
    Add(wall_, 0, {0, kWallHeight, side});
    btRigidBody& across = Add(wall_, 0, {side, kWallHeight, 0});
    across.setWorldTransform(At({side, kWallHeight, 0}, {btVector3(0, 1, 0), SIMD_HALF_PI}));
  }
}

void BulletGame::BuildStack() {
  for (int i = 0; i < options_.stack_height; ++i) {
    Add(box_, 1, {Random(-0.1F, 0.1F), 0.5F + static_cast<float>(i) * 1.01F, Random(-0.1F, 0.1F)});
  }
}

void BulletGame::BuildPile() {
  const int across = std::max(1, static_cast<int>(options_.half_width / kGap));
  for (int i = 0; i < options_.pile_count; ++i) {
    const auto at = [&](int cell) { return (static_cast<float>(cell) - across / 2.0F) * kGap; };
    const float height = 3 + static_cast<float>(i / (across * across)) * kGap;
    AddLoose({at(i % across) + Random(-0.2F, 0.2F), height,
              at(i / across % across) + Random(-0.2F, 0.2F)});
  }
}

// The capsules lie in a row along z; each joint bends by up to 45 degrees.
void BulletGame::BuildChain(int index) {
  constexpr int kLinks = 8;
  const btQuaternion along_z(btVector3(1, 0, 0), SIMD_HALF_PI);
  const float x = Random(-3, 3);
  const float height = 6 + static_cast<float>(index);
  btRigidBody* before = nullptr;
  for (int i = 0; i < kLinks; ++i) {
    const float z = static_cast<float>(i) - kLinks / 2.0F;
    btRigidBody& link = Add(limb_, 1, {x, height, z});
    link.setWorldTransform(At({x, height, z}, along_z));
    link.setInterpolationWorldTransform(link.getWorldTransform());
    if (before != nullptr) {
      joints_.push_back(std::make_unique<btConeTwistConstraint>(*before, link, At({0, 0.5F, 0}),
                                                                At({0, -0.5F, 0})));
      static_cast<btConeTwistConstraint&>(*joints_.back())
          .setLimit(SIMD_HALF_PI / 2, SIMD_HALF_PI / 2, SIMD_HALF_PI / 2);
      world_.addConstraint(joints_.back().get(), /*disableCollisionsBetweenLinkedBodies=*/true);
    }
    before = &link;
  }
}

void BulletGame::BuildLifts() {
  for (int i = 0; i < options_.lift_count; ++i) {
    btRigidBody& lift = Add(plank_, 0, {static_cast<float>(2 * i), 0.5F, 4});
    lift.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    lift.setActivationState(DISABLE_DEACTIVATION);
    lifts_.push_back(&lift);
  }
}

void BulletGame::Remove(btRigidBody& body) {
  world_.removeRigidBody(&body);
  std::erase_if(bodies_, [&](const auto& own) { return own.get() == &body; });
}

// Moves up for three seconds and down for three, in steps that are exact in floats.
void BulletGame::MoveLifts() {
  const bool up = step_count_ / 180 % 2 == 0;
  for (btRigidBody* const lift : lifts_) {
    btTransform place = lift->getWorldTransform();
    place.getOrigin() += btVector3(0, up ? 1.0F / 128 : -1.0F / 128, 0);
    lift->setWorldTransform(place);
  }
}

void BulletGame::LetVisitorsCome() {
  if (options_.visitor_interval == 0 || step_count_ % options_.visitor_interval != 0) return;
  if (static_cast<int>(visitors_.size()) >= options_.visitor_limit) {
    Remove(*visitors_.front());
    visitors_.pop_front();
  }
  const float reach = options_.half_width / 2;
  visitors_.push_back(&AddLoose({Random(-reach, reach), 8, Random(-reach, reach)}));
  visitors_.back()->setLinearVelocity({Random(-5, 5), -5, Random(-5, 5)});
}

void BulletGame::Blow() {
  for (const auto& body : bodies_) {
    if (body->isStaticOrKinematicObject() || Random(0, 1) > 0.3F) continue;
    body->activate();
    body->applyCentralImpulse({Random(-3, 3), Random(2, 6), Random(-3, 3)});
  }
}

void BulletGame::Phase() {
  constexpr int kPhaseSteps = 10;
  const int step = step_count_ % options_.phase_interval;
  if (step != 0 && step != kPhaseSteps) return;
  for (const auto& body : bodies_) {
    if (body->isStaticOrKinematicObject()) continue;
    const bool collides = step == kPhaseSteps || Random(0, 1) > 0.3F;
    body->getBroadphaseProxy()->m_collisionFilterMask = collides ? btBroadphaseProxy::AllFilter : 0;
  }
}

// Updates the boxes first, because the bodies have moved since the last step updated them.
void BulletGame::Query() {
  world_.updateAabbs();
  const float reach = options_.half_width;
  const btVector3 from(Random(-reach, reach), 9, Random(-reach, reach));
  const btVector3 to(Random(-reach, reach), -1, Random(-reach, reach));
  HashRay(from, to);
  HashSweep(from, to);
  HashBox(to);
}

void BulletGame::HashRay(const btVector3& from, const btVector3& to) {
  btCollisionWorld::ClosestRayResultCallback nearest(from, to);
  world_.rayTest(from, to, nearest);
  Mix(std::bit_cast<uint32_t>(nearest.m_closestHitFraction));
  if (nearest.hasHit()) Mix(static_cast<uint64_t>(nearest.m_collisionObject->getUserIndex()));
}

void BulletGame::HashSweep(const btVector3& from, const btVector3& to) {
  btCollisionWorld::ClosestConvexResultCallback nearest(from, to);
  world_.convexSweepTest(&ball_, At(from), At(to), nearest);
  Mix(std::bit_cast<uint32_t>(nearest.m_closestHitFraction));
  if (nearest.hasHit()) Mix(static_cast<uint64_t>(nearest.m_hitCollisionObject->getUserIndex()));
}

void BulletGame::HashBox(const btVector3& middle) {
  const btVector3 half(3, 3, 3);
  BodiesInBox bodies(middle - half, middle + half);
  world_.getBroadphase()->aabbTest(middle - half, middle + half, bodies);
  for (const int id : bodies.SortedIds()) Mix(static_cast<uint64_t>(id));
}

void BulletGame::HashBodies() {
  for (const auto& body : bodies_) {
    Mix(static_cast<uint64_t>(body->getUserIndex()));
    Mix(static_cast<uint64_t>(body->getActivationState()));
    Mix(body->getWorldTransform().getOrigin());
    for (int row = 0; row < 3; ++row) Mix(body->getWorldTransform().getBasis()[row]);
    Mix(body->getLinearVelocity());
    Mix(body->getAngularVelocity());
  }
}

void BulletGame::Mix(const btVector3& value) {
  for (int axis = 0; axis < 3; ++axis) Mix(std::bit_cast<uint32_t>(value[axis]));
}

float BulletGame::Random(float low, float high) {
  constexpr float kRange = std::minstd_rand::max() - std::minstd_rand::min();
  return low + (high - low) * static_cast<float>(random_() - std::minstd_rand::min()) / kRange;
}

}  // namespace sweepstake::test_support
