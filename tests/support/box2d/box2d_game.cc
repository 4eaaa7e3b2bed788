#include "tests/support/box2d/box2d_game.h"

#include <algorithm>
#include <cmath>

namespace sweepstake::test_support {

Box2dGameOptions Box2dPileOf(int body_count) {
  return {.pile_count = body_count,
          .half_width = std::max(3.0F, static_cast<float>(body_count) / 40)};
}

// Bodies do not sleep, and there are no times of impact, because the world then makes calls that
// this class cannot know.
Box2dGame::Box2dGame(const Box2dGameOptions& options) : options_(options) {
  world_.SetAllowSleeping(false);
  world_.SetContinuousPhysics(false);
  const float wall = options.half_width + 1;
  const b2BodyDef static_body;
  b2Body& ground = *world_.CreateBody(&static_body);
  for (const b2Vec2& side : {b2Vec2(0, -1), b2Vec2(-wall, 50), b2Vec2(wall, 50)}) {
    b2PolygonShape box;
    box.SetAsBox(side.x == 0 ? wall : 1, side.x == 0 ? 1 : 50, side, 0);
    AddFixture(ground, box);
  }
  const int across = std::max(1, static_cast<int>(options.half_width * 2));
  for (int i = 0; i < options.pile_count; ++i) {
    const float x = static_cast<float>(i % across) - options.half_width + 0.5F;
    const int layer = i / across;
    AddBody(x + Random(-0.1F, 0.1F), 1 + static_cast<float>(layer));
  }
}

void Box2dGame::PlayEvents() {
  if (step_count_ == 0) return;  // the first search is for the bodies of the constructor
  destroyed_.clear();
  created_.clear();
  if (options_.visitor_interval == 0 || step_count_ % options_.visitor_interval != 0) return;
  for (b2Fixture* fixture = bodies_.front()->GetFixtureList(); fixture != nullptr;
       fixture = fixture->GetNext()) {
    destroyed_.push_back(fixture);
  }
  world_.DestroyBody(bodies_.front());
  bodies_.pop_front();
  AddBody(Random(-options_.half_width, options_.half_width) / 2, 30);
  bodies_.back()->SetLinearVelocity({Random(-20, 20), -30});
}

// The boxes and displacements are those of b2Fixture::Synchronize.
void Box2dGame::Step() {
  before_.clear();
  for (b2Body* const body : bodies_) {
    before_.push_back({body, body->GetWorldCenter(), body->GetAngle()});
  }
  world_.Step(1.0F / 60, /*velocityIterations=*/8, /*positionIterations=*/3);
  ++step_count_;
  moved_.clear();
  for (const auto& [body, center, angle] : before_) {
    b2Transform transform;
    transform.q.Set(angle);
    transform.p = center - b2Mul(transform.q, body->GetLocalCenter());
    for (b2Fixture* fixture = body->GetFixtureList(); fixture != nullptr;
         fixture = fixture->GetNext()) {
      b2AABB first;
      b2AABB last;
      fixture->GetShape()->ComputeAABB(&first, transform, 0);
      fixture->GetShape()->ComputeAABB(&last, body->GetTransform(), 0);
      b2AABB both;
      both.Combine(first, last);
      moved_.push_back({fixture, both, last.GetCenter() - first.GetCenter()});
    }
  }
}

void Box2dGame::AddFixture(b2Body& body, const b2Shape& shape) {
  b2FixtureDef definition;
  definition.shape = &shape;
  definition.density = 1;
  definition.friction = 0.4F;
  definition.userData.pointer = next_number_++;
  if (next_number_ % 7 == 0) definition.filter.categoryBits = 2;
  if (next_number_ % 11 == 0) definition.filter.maskBits = 1;
  b2Fixture* const fixture = body.CreateFixture(&definition);
  created_.push_back({fixture, fixture->GetAABB(0), b2Vec2(0, 0)});
}

void Box2dGame::AddBody(float x, float y) {
  b2BodyDef definition;
  definition.type = b2_dynamicBody;
  definition.position.Set(x, y);
  b2Body& body = *world_.CreateBody(&definition);
  if (random_() % 2 == 0) {
    b2CircleShape circle;
    circle.m_radius = Random(0.2F, 0.45F);
    AddFixture(body, circle);
  } else {
    b2PolygonShape box;
    box.SetAsBox(Random(0.2F, 0.45F), Random(0.2F, 0.45F));
    AddFixture(body, box);
  }
  if (random_() % 4 == 0) {
    b2CircleShape second;
    second.m_radius = 0.2F;
    second.m_p.Set(0.4F, 0);
    AddFixture(body, second);
  }
  bodies_.push_back(&body);
}

float Box2dGame::Random(float low, float high) {
  constexpr auto kRange = static_cast<float>(std::minstd_rand::max() - std::minstd_rand::min());
  return low + (high - low) * static_cast<float>(random_() - std::minstd_rand::min()) / kRange;
}

}  // namespace sweepstake::test_support
