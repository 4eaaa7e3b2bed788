// Compares queries with scans of all proxies.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <span>
#include <thread>
#include <vector>

#include "engine_client/broad_phase/proxies/query_shapes.h"
#include "sweepstake/proxy_set.h"
#include "tests/engine_client/broad_phase/each_simd_target.h"
#include "tests/engine_client/broad_phase/proxies/proxy_game.h"

namespace sweepstake {
namespace {

using test_support::kUnit;
using test_support::ListedProxy;
using test_support::ProxyGame;

std::vector<ProxyHandle> ScanForBox(const ProxyGame& game, const Aabb& box,
                                    const CollisionFilter& filter) {
  std::vector<ProxyHandle> found;
  for (const ListedProxy& proxy : game.listed) {
    if (Overlap(proxy.box, box) && Passes(proxy.options.filter, filter)) {
      found.push_back(proxy.handle);
    }
  }
  std::ranges::sort(found);
  return found;
}

std::vector<ProxyHandle> ScanForSphere(const ProxyGame& game, const Sphere& sphere,
                                       const CollisionFilter& filter) {
  std::vector<ProxyHandle> found;
  for (const ListedProxy& proxy : game.listed) {
    if (!IsValid(proxy.box) || !Passes(proxy.options.filter, filter)) continue;
    const float distance = SquaredDistance(sphere.center, proxy.box);
    if (distance <= sphere.radius * sphere.radius) found.push_back(proxy.handle);
  }
  std::ranges::sort(found);
  return found;
}

// Returns the hits of a ray or swept box, sorted by distance.
template <typename Shape>
std::vector<RayHit> ScanForHits(const ProxyGame& game, const Shape& shape,
                                const CollisionFilter& filter) {
  std::vector<RayHit> hits;
  for (const ListedProxy& proxy : game.listed) {
    const auto distance = EnterDistance(SlabsOf(shape), proxy.box);
    if (distance && Passes(proxy.options.filter, filter)) hits.push_back({proxy.handle, *distance});
  }
  std::ranges::sort(hits, [](const RayHit& a, const RayHit& b) {
    return std::pair(a.distance, a.proxy) < std::pair(b.distance, b.proxy);
  });
  return hits;
}

// Returns a ray along an axis, in a plane or without a direction; it may be short, infinite, tiny
// or huge.
Ray RandomRay(ProxyGame& game) {
  SequentialRandom& random = game.random();
  Ray ray{};
  const Aabb start = game.BoxAt(0);
  std::copy_n(start.min, 3, ray.origin);
  for (float& along : ray.direction) {
    if (random.Below(3) != 0) along = random.Symmetric();
  }
  if (random.Below(3) == 0) ray.max_distance = random.Between(0, 5);
  if (random.Below(8) == 0) ray.origin[random.Below(3)] = -1e30F;
  if (random.Below(8) == 0) ray.direction[random.Below(3)] = 1e-40F;
  if (random.Below(8) == 0) ray.direction[random.Below(3)] *= 1e30F;
  return ray;
}

BoxSweep RandomSweep(ProxyGame& game) {
  const Ray way = RandomRay(game);
  BoxSweep sweep{game.BoxAt(game.random().Below(3) == 0 ? 0 : game.random().Between(0, 2)), {}};
  for (int axis = 0; axis < 3; ++axis) sweep.translation[axis] = 4 * way.direction[axis];
  return sweep;
}

Sphere RandomSphere(ProxyGame& game) {
  Sphere sphere{};
  std::copy_n(game.BoxAt(0).min, 3, sphere.center);
  const float radii[] = {0, 0.5F, 1, game.random().Between(0, 4), 1e-30F, Sphere::kMaxRadius};
  sphere.radius = radii[game.random().Below(std::size(radii))];
  return sphere;
}

// Calls the const query for the shape, which fills a buffer. `count` is the number of all results.
Status Ask(const ProxySet& proxies, const Aabb& box, const CollisionFilter& filter,
           std::span<ProxyHandle> found, size_t& count) {
  return proxies.QueryBox(box, filter, found, count);
}
Status Ask(const ProxySet& proxies, const Sphere& sphere, const CollisionFilter& filter,
           std::span<ProxyHandle> found, size_t& count) {
  return proxies.QuerySphere(sphere, filter, found, count);
}
Status Ask(const ProxySet& proxies, const Ray& ray, const CollisionFilter& filter,
           std::span<RayHit> hits, size_t& count) {
  return proxies.CastRay(ray, filter, hits, count);
}
Status Ask(const ProxySet& proxies, const BoxSweep& sweep, const CollisionFilter& filter,
           std::span<RayHit> hits, size_t& count) {
  return proxies.SweepBox(sweep, filter, hits, count);
}

// Checks the const query. REQUIRES: the queries of `proxies` are prepared.
template <typename Shape, typename T>
void ExpectConstAnswer(const ProxySet& proxies, const Shape& shape, const CollisionFilter& filter,
                       const std::vector<T>& expected) {
  std::vector<T> room(expected.size() + 2);
  size_t count = 0;
  ASSERT_TRUE(Ask(proxies, shape, filter, std::span(room), count).ok());
  ASSERT_EQ(count, expected.size());
  ASSERT_TRUE(std::equal(expected.begin(), expected.end(), room.begin()));
  ASSERT_EQ(room.back(), T{});
  // If the buffer is too small, the query still returns the number of hits, and fills the buffer
  // with some of them.
  count = 0;
  std::vector<T> few(expected.size() / 2);
  ASSERT_TRUE(Ask(proxies, shape, filter, std::span(few), count).ok());
  ASSERT_EQ(count, expected.size());
  for (const T& one : few) ASSERT_NE(std::ranges::find(expected, one), expected.end());
}

void ExpectRightHits(ProxyGame& game, const Ray& ray, const BoxSweep& sweep,
                     const CollisionFilter& filter) {
  std::vector<RayHit> hits;
  RayHit nearest;
  const std::vector<RayHit> by_ray = ScanForHits(game, ray, filter);
  ASSERT_TRUE(game.proxies.CastRay(ray, filter, hits).ok());
  ASSERT_EQ(hits, by_ray);
  ASSERT_TRUE(game.proxies.CastRayNearest(ray, filter, nearest).ok());
  ASSERT_EQ(nearest, by_ray.empty() ? RayHit{} : by_ray.front());
  const std::vector<RayHit> by_sweep = ScanForHits(game, sweep, filter);
  ASSERT_TRUE(game.proxies.SweepBox(sweep, filter, hits).ok());
  ASSERT_EQ(hits, by_sweep);
  ASSERT_TRUE(game.proxies.SweepBoxNearest(sweep, filter, nearest).ok());
  ASSERT_EQ(nearest, by_sweep.empty() ? RayHit{} : by_sweep.front());
  ExpectConstAnswer(game.proxies, ray, filter, by_ray);
  ExpectConstAnswer(game.proxies, sweep, filter, by_sweep);
}

void ExpectRightAnswers(ProxyGame& game, int question_count) {
  std::vector<ProxyHandle> found;
  for (int k = 0; k < question_count; ++k) {
    const CollisionFilter filter = game.RandomFilter();
    const Aabb box = k % 5 == 0 ? game.BoxAt(3) : k % 5 == 1 ? game.BoxAt(0) : game.RandomBox();
    const std::vector<ProxyHandle> in_box = ScanForBox(game, box, filter);
    game.proxies.QueryBox(box, filter, found);
    ASSERT_EQ(found, in_box);
    const Sphere sphere = RandomSphere(game);
    const std::vector<ProxyHandle> in_sphere = ScanForSphere(game, sphere, filter);
    ASSERT_TRUE(game.proxies.QuerySphere(sphere, filter, found).ok());
    ASSERT_EQ(found, in_sphere);
    ExpectConstAnswer(game.proxies, box, filter, in_box);
    ExpectConstAnswer(game.proxies, sphere, filter, in_sphere);
    ExpectRightHits(game, RandomRay(game), RandomSweep(game), filter);
    if (testing::Test::HasFatalFailure()) return;
  }
}

TEST(Queries, AgreeWithAScanWhileProxiesAreAddedAndRemoved) {
  ProxyGame game({}, 17);
  game.AddSome(150, 100);
  for (int frame = 0; frame < 200; ++frame) {
    game.Step();
    ExpectRightAnswers(game, 4);
    if (HasFatalFailure()) FAIL() << "in frame " << frame;
  }
}

TEST(Queries, AgreeWithAScanInALargeScene) {
  ProxyGame game({}, 18, 25);
  game.AddSome(5000, 9000);
  ExpectRightAnswers(game, 300);
  for (int frame = 0; frame < 5; ++frame) {
    game.Step();
    ExpectRightAnswers(game, 20);
  }
}

TEST(Queries, FindTheSameOnEachInstructionSet) {
  test_support::OnEachSimdTarget([] {
    ProxyGame game({}, 19);
    game.AddSome(300, 300);
    ExpectRightAnswers(game, 200);
  });
}

TEST(Queries, FindNothingInAnEmptySet) {
  ProxySet proxies;
  std::vector<ProxyHandle> found(1);
  std::vector<RayHit> hits(1);
  RayHit nearest{{0, 1}, 1};
  proxies.QueryBox({{0, 0, 0}, {1, 1, 1}}, {}, found);
  EXPECT_TRUE(found.empty());
  EXPECT_TRUE(proxies.CastRay({{0, 0, 0}, {1, 0, 0}}, {}, hits).ok());
  EXPECT_TRUE(hits.empty());
  EXPECT_TRUE(proxies.CastRayNearest({{0, 0, 0}, {1, 0, 0}}, {}, nearest).ok());
  EXPECT_EQ(nearest, RayHit{});
}

TEST(Queries, CanRunOnSeveralThreadsOncePrepared) {
  ProxyGame game({}, 20);
  game.AddSome(400, 400);
  game.proxies.PrepareQueries();
  const Aabb box{{2, 2, 2}, {5, 5, 5}};
  const Ray ray{{-1, 4, 4}, {1, 0, 0.01F}};
  const auto ask = [&] {
    std::vector<ProxyHandle> found;
    std::vector<RayHit> hits;
    for (int k = 0; k < 50; ++k) {
      game.proxies.QueryBox(box, {}, found);
      EXPECT_EQ(found, ScanForBox(game, box, {}));
      EXPECT_TRUE(game.proxies.CastRay(ray, {}, hits).ok());
      EXPECT_EQ(hits, ScanForHits(game, ray, {}));
    }
  };
  std::jthread other(ask);
  ask();
}

TEST(Queries, InABatchEqualSingleOnes) {
  ProxyGame game({}, 23);
  game.AddSome(200, 200);
  game.proxies.PrepareQueries();
  const ProxySet& proxies = game.proxies;
  std::vector<Ray> rays;
  std::vector<Aabb> boxes;
  for (int k = 0; k < 64; ++k) {
    rays.push_back(RandomRay(game));
    boxes.push_back(game.RandomBox());
  }
  std::vector<RayHit> hits(rays.size());
  ASSERT_TRUE(proxies.CastRays(rays, {}, hits).ok());
  std::vector<ProxyHandle> room(100'000);
  std::vector<size_t> ends(boxes.size());
  ASSERT_TRUE(proxies.QueryBoxes(boxes, {}, room, ends).ok());
  std::vector<size_t> ends_without_room(boxes.size());
  std::array<ProxyHandle, 3> little_room;
  ASSERT_TRUE(proxies.QueryBoxes(boxes, {}, little_room, ends_without_room).ok());
  EXPECT_EQ(ends_without_room, ends);
  for (size_t k = 0; k < boxes.size(); ++k) {
    RayHit nearest;
    ASSERT_TRUE(proxies.CastRayNearest(rays[k], {}, nearest).ok());
    EXPECT_EQ(hits[k], nearest);
    const size_t begin = k == 0 ? 0 : ends[k - 1];
    const std::span found = std::span(room).subspan(begin, ends[k] - begin);
    EXPECT_TRUE(std::ranges::equal(found, ScanForBox(game, boxes[k], {})));
  }
  rays[7].max_distance = -1;
  const Status wrong = proxies.CastRays(rays, {}, hits);
  EXPECT_EQ(wrong.code(), StatusCode::kInvalidArgument);
  EXPECT_EQ(wrong.message(), "ray 7: the ray's max_distance must not be negative");
}

TEST(ConstQueries, NeedAPreparationAfterEachChange) {
  ProxySet proxies;
  const ProxyHandle handle = proxies.Add({{0, 0, 0}, {1, 1, 1}});
  const ProxySet& for_all = proxies;
  std::array<ProxyHandle, 4> found;
  size_t count = 7;
  const auto ask = [&] {
    return for_all.QueryBox({{0, 0, 0}, {1, 1, 1}}, {}, found, count).code();
  };
  EXPECT_EQ(ask(), StatusCode::kFailedPrecondition);
  EXPECT_EQ(count, 7U);
  proxies.PrepareQueries();
  EXPECT_EQ(ask(), StatusCode::kOk);
  EXPECT_EQ(count, 1U);
  EXPECT_EQ(found[0], handle);
  ASSERT_TRUE(proxies.SetUser(handle, 5));
  EXPECT_EQ(ask(), StatusCode::kOk);
  ASSERT_TRUE(proxies.Move(handle, {{5, 5, 5}, {6, 6, 6}}));
  EXPECT_EQ(ask(), StatusCode::kFailedPrecondition);
}

// The proxies are not in the order of their ids, since one was removed.
TEST(ANearestHit, IsTheOneWithTheLowestIdOfSeveralAtTheSameDistance) {
  for (const bool is_static : {false, true}) {
    ProxySet proxies;
    const ProxyOptions options{.is_static = is_static};
    const ProxyHandle removed = proxies.Add(kUnit, options);
    const ProxyHandle lower = proxies.Add(kUnit, options);
    proxies.Add(kUnit, options);
    ASSERT_TRUE(proxies.Remove(removed));
    RayHit nearest;
    ASSERT_TRUE(proxies.CastRayNearest({{-1, 0.5F, 0.5F}, {1, 0, 0}}, {}, nearest).ok());
    EXPECT_EQ(nearest, (RayHit{lower, 1}));
  }
}

TEST(ASphere, TouchesABoxAtItsRadiusFromTheNearestPoint) {
  ProxySet proxies;
  const ProxyHandle box = proxies.Add({{1, 1, 1}, {2, 2, 2}});
  std::vector<ProxyHandle> found;
  const auto touches = [&](const Sphere& sphere) {
    EXPECT_TRUE(proxies.QuerySphere(sphere, {}, found).ok());
    return found == std::vector{box};
  };
  EXPECT_TRUE(touches({{0, 1.5F, 1.5F}, 1}));
  EXPECT_FALSE(touches({{0, 1.5F, 1.5F}, 0.999F}));
  EXPECT_TRUE(touches({{-2, -3, 1}, 5}));     // touches an edge at the distances 3 and 4
  EXPECT_FALSE(touches({{0, 0, 0}, 1.73F}));  // the corner is √3 away
  EXPECT_TRUE(touches({{0, 0, 0}, 1.74F}));
  EXPECT_TRUE(touches({{1.5F, 1.5F, 1.5F}, 0}));
  EXPECT_FALSE(touches({{1e30F, 0, 0}, Sphere::kMaxRadius}));
}

TEST(Queries, RefuseInvalidShapesAndKeepTheResults) {
  const float infinity = std::numeric_limits<float>::infinity();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  ProxySet proxies;
  std::vector<ProxyHandle> found(3);
  for (const Sphere& sphere : {Sphere{{0, 0, 0}, -1}, Sphere{{0, nan, 0}, 1},
                               Sphere{{0, 0, 0}, nan}, Sphere{{0, 0, 0}, 1.01e19F}}) {
    EXPECT_EQ(proxies.QuerySphere(sphere, {}, found).code(), StatusCode::kInvalidArgument);
  }
  EXPECT_EQ(found.size(), 3U);
  std::vector<RayHit> hits(3);
  RayHit nearest{{1, 1}, 7};
  for (const BoxSweep& sweep :
       {BoxSweep{{{0, 0, 0}, {1, 1, -1}}, {1, 0, 0}}, BoxSweep{{{0, 0, 0}, {1, nan, 1}}, {1, 0, 0}},
        BoxSweep{{{0, 0, 0}, {1, 1, 1}}, {infinity, 0, 0}}}) {
    EXPECT_EQ(proxies.SweepBox(sweep, {}, hits).code(), StatusCode::kInvalidArgument);
    EXPECT_EQ(proxies.SweepBoxNearest(sweep, {}, nearest).code(), StatusCode::kInvalidArgument);
  }
  EXPECT_EQ(hits.size(), 3U);
  EXPECT_EQ(nearest, (RayHit{{1, 1}, 7}));
}

TEST(ASweptBox, TouchesWhereItsFaceReachesTheOtherBox) {
  ProxySet proxies;
  const ProxyHandle wall = proxies.Add({{4, 0, 0}, {5, 9, 9}}, {.is_static = true});
  std::vector<RayHit> hits;
  ASSERT_TRUE(proxies.SweepBox({{{1, 1, 1}, {2, 2, 2}}, {4, 0, 0}}, {}, hits).ok());
  EXPECT_EQ(hits, (std::vector{RayHit{wall, 0.5F}}));
  ASSERT_TRUE(proxies.SweepBox({{{1, 1, 1}, {2, 2, 2}}, {1.99F, 0, 0}}, {}, hits).ok());
  EXPECT_TRUE(hits.empty());
  ASSERT_TRUE(proxies.SweepBox({{{1, 1, 1}, {4, 2, 2}}, {0, 0, 0}}, {}, hits).ok());
  EXPECT_EQ(hits, (std::vector{RayHit{wall, 0}}));
}

// A set with one box from 1 to 2 on each axis.
class ARay : public testing::Test {
 protected:
  std::vector<RayHit> Cast(const Ray& ray) {
    std::vector<RayHit> hits;
    EXPECT_TRUE(proxies_.CastRay(ray, {}, hits).ok());
    return hits;
  }

  ProxySet proxies_;
  ProxyHandle handle_ = proxies_.Add({{1, 1, 1}, {2, 2, 2}});
};

TEST_F(ARay, EntersAtTheFirstFace) {
  EXPECT_EQ(Cast({{0, 1.5F, 1.5F}, {1, 0, 0}}), (std::vector{RayHit{handle_, 1}}));
  EXPECT_EQ(Cast({{4, 1.5F, 1.5F}, {-2, 0, 0}}), (std::vector{RayHit{handle_, 1}}));
  EXPECT_EQ(Cast({{0, 0, 0}, {0.5F, 0.5F, 0.5F}}), (std::vector{RayHit{handle_, 2}}));
  EXPECT_TRUE(Cast({{0, 1.5F, 1.5F}, {-1, 0, 0}}).empty());
  EXPECT_TRUE(Cast({{0, 2.5F, 1.5F}, {1, 0, 0}}).empty());
}

TEST_F(ARay, ThatStartsInsideOrOnAFaceEntersAtZero) {
  EXPECT_EQ(Cast({{1.5F, 1.5F, 1.5F}, {0, 0, -1}}), (std::vector{RayHit{handle_, 0}}));
  EXPECT_EQ(Cast({{2, 1.5F, 1.5F}, {1, 0, 0}}), (std::vector{RayHit{handle_, 0}}));
  EXPECT_EQ(Cast({{1.5F, 1.5F, 1.5F}, {0, 0, 0}}), (std::vector{RayHit{handle_, 0}}));
  EXPECT_TRUE(Cast({{2.5F, 1.5F, 1.5F}, {0, 0, 0}}).empty());
}

TEST_F(ARay, HitsFacesAndEdgesThatItOnlyTouches) {
  EXPECT_EQ(Cast({{0, 2, 1.5F}, {1, 0, 0}}), (std::vector{RayHit{handle_, 1}}));
  EXPECT_EQ(Cast({{0, 2, 2}, {1, -0.0F, 0}}), (std::vector{RayHit{handle_, 1}}));
  EXPECT_EQ(Cast({{0, 3, 1.5F}, {1, -1, 0}}), (std::vector{RayHit{handle_, 1}}));
}

TEST_F(ARay, EndsAtItsMaximumDistance) {
  EXPECT_EQ(Cast({{0, 1.5F, 1.5F}, {1, 0, 0}, 1}).size(), 1U);
  EXPECT_TRUE(Cast({{0, 1.5F, 1.5F}, {1, 0, 0}, 0.999F}).empty());
  EXPECT_EQ(Cast({{1, 1.5F, 1.5F}, {1, 0, 0}, 0}).size(), 1U);
}

TEST_F(ARay, ThatIsInvalidIsAnErrorAndKeepsTheHits) {
  const float infinity = std::numeric_limits<float>::infinity();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::vector<RayHit> hits(3);
  RayHit nearest{handle_, 7};
  for (const Ray& ray : {Ray{{nan, 0, 0}, {1, 0, 0}}, Ray{{0, 0, 0}, {0, infinity, 0}},
                         Ray{{0, 0, 0}, {1, 0, 0}, infinity}, Ray{{0, 0, 0}, {1, 0, 0}, nan},
                         Ray{{0, 0, 0}, {1, 0, 0}, -1}}) {
    EXPECT_EQ(proxies_.CastRay(ray, {}, hits).code(), StatusCode::kInvalidArgument);
    EXPECT_EQ(proxies_.CastRayNearest(ray, {}, nearest).code(), StatusCode::kInvalidArgument);
    EXPECT_EQ(hits.size(), 3U);
    EXPECT_EQ(nearest, (RayHit{handle_, 7}));
  }
}

TEST_F(ARay, HitsTheLowestIndexFirstAtEqualDistances) {
  const ProxyHandle resting = proxies_.Add({{1, 1, 1}, {2, 2, 2}}, {.is_static = true});
  const ProxyHandle moving = proxies_.Add({{1, 1, 1}, {2, 2, 2}});
  const Ray ray{{0, 1.5F, 1.5F}, {1, 0, 0}};
  EXPECT_EQ(Cast(ray), (std::vector{RayHit{handle_, 1}, RayHit{moving, 1}, RayHit{resting, 1}}));
  RayHit nearest;
  EXPECT_TRUE(proxies_.CastRayNearest(ray, {}, nearest).ok());
  EXPECT_EQ(nearest, (RayHit{handle_, 1}));
  EXPECT_TRUE(proxies_.Remove(handle_));
  EXPECT_TRUE(proxies_.Remove(moving));
  EXPECT_TRUE(proxies_.CastRayNearest(ray, {}, nearest).ok());
  EXPECT_EQ(nearest, (RayHit{resting, 1}));
}

}  // namespace
}  // namespace sweepstake
