// A game on a world of Box2D that lists the calls by which the world changes its broad phase, so
// that other broad phases can get the same calls.
//
// Not thread-safe. Lengths are in metres; one step is 1/60 s.
#pragma once

#include <box2d/box2d.h>

#include <cstdint>
#include <deque>
#include <random>
#include <span>
#include <vector>

namespace sweepstake::test_support {

struct Box2dGameOptions {
  int pile_count = 0;        // bodies of one or two fixtures that fall between two walls
  int visitor_interval = 0;  // steps between two visitors; the oldest body leaves; 0: none
  float half_width = 10;     // distance from the centre to a wall
};

// Returns options for bodies in a pit, about twenty layers deep.
Box2dGameOptions Box2dPileOf(int body_count);

class Box2dGame {
 public:
  // One call of CreateProxy (without displacement) or MoveProxy.
  struct Call {
    b2Fixture* fixture;
    b2AABB box;
    b2Vec2 displacement;
  };

  explicit Box2dGame(const Box2dGameOptions& options);

  // Removes and adds bodies. The world searches at the beginning of the next step if created() is
  // not empty.
  void PlayEvents();
  // Steps the world, which moves the proxies of moved(), and then searches.
  void Step();

  std::span<b2Fixture* const> destroyed() const { return destroyed_; }  // already deleted
  std::span<const Call> created() const { return created_; }            // by PlayEvents
  std::span<const Call> moved() const { return moved_; }                // by the latest Step
  const b2World& world() const { return world_; }

 private:
  struct Sweep {
    b2Body* body;
    b2Vec2 center;
    float angle;
  };

  void AddFixture(b2Body& body, const b2Shape& shape);
  void AddBody(float x, float y);
  float Random(float low, float high);

  const Box2dGameOptions options_;
  b2World world_{b2Vec2(0, -10)};
  std::deque<b2Body*> bodies_;
  std::vector<b2Fixture*> destroyed_;
  std::vector<Call> created_;
  std::vector<Call> moved_;
  std::vector<Sweep> before_;
  std::minstd_rand random_{1};
  uintptr_t next_number_ = 0;
  int step_count_ = 0;
};

}  // namespace sweepstake::test_support
