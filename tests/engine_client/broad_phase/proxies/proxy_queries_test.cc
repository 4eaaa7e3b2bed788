// Queries against scans of every proxy.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <thread>
#include <vector>

#include "engine_client/broad_phase/proxies/ray_slabs.h"
#include "sweepstake/proxy_set.h"
#include "tests/engine_client/broad_phase/each_simd_target.h"
#include "tests/engine_client/broad_phase/proxies/proxy_game.h"

namespace sweepstake {
namespace {

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

std::vector<RayHit> ScanForRay(const ProxyGame& game, const Ray& ray,
                               const CollisionFilter& filter) {
  std::vector<RayHit> hits;
  for (const ListedProxy& proxy : game.listed) {
    const auto distance = EnterDistance(ray, proxy.box);
    if (distance && Passes(proxy.options.filter, filter)) hits.push_back({proxy.handle, *distance});
  }
  std::ranges::sort(hits, [](const RayHit& a, const RayHit& b) {
    return std::pair(a.distance, a.proxy) < std::pair(b.distance, b.proxy);
  });
  return hits;
}

// Returns a ray along an axis, in a plane or without a direction, which may be short, endless, tiny
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

void ExpectRightAnswers(ProxyGame& game, int question_count) {
  std::vector<ProxyHandle> found;
  std::vector<RayHit> hits;
  RayHit nearest;
  for (int k = 0; k < question_count; ++k) {
    const CollisionFilter filter = game.RandomFilter();
    const Aabb box = k % 5 == 0 ? game.BoxAt(3) : game.RandomBox();
    game.proxies.QueryBox(box, filter, found);
    ASSERT_EQ(found, ScanForBox(game, box, filter));
    const Ray ray = RandomRay(game);
    const std::vector<RayHit> expected = ScanForRay(game, ray, filter);
    ASSERT_TRUE(game.proxies.CastRay(ray, filter, hits).ok());
    ASSERT_EQ(hits, expected);
    ASSERT_TRUE(game.proxies.CastRayNearest(ray, filter, nearest).ok());
    ASSERT_EQ(nearest, expected.empty() ? RayHit{} : expected.front());
  }
}

TEST(Queries, FindWhatAScanFindsWhileProxiesComeAndGo) {
  ProxyGame game({}, 17);
  game.AddSome(150, 100);
  for (int frame = 0; frame < 200; ++frame) {
    game.Step();
    ExpectRightAnswers(game, 4);
    if (HasFatalFailure()) FAIL() << "in frame " << frame;
  }
}

TEST(Queries, FindWhatAScanFindsInALargeScene) {
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

TEST(Queries, FindNothingAmongNothing) {
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

TEST(Queries, MayRunSideBySideOncePrepared) {
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
      EXPECT_EQ(hits, ScanForRay(game, ray, {}));
    }
  };
  std::jthread other(ask);
  ask();
}

// One box from 1 to 2 on each axis.
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

TEST_F(ARay, EntersWhereItMeetsTheFirstFace) {
  EXPECT_EQ(Cast({{0, 1.5F, 1.5F}, {1, 0, 0}}), (std::vector{RayHit{handle_, 1}}));
  EXPECT_EQ(Cast({{4, 1.5F, 1.5F}, {-2, 0, 0}}), (std::vector{RayHit{handle_, 1}}));
  EXPECT_EQ(Cast({{0, 0, 0}, {0.5F, 0.5F, 0.5F}}), (std::vector{RayHit{handle_, 2}}));
  EXPECT_TRUE(Cast({{0, 1.5F, 1.5F}, {-1, 0, 0}}).empty());
  EXPECT_TRUE(Cast({{0, 2.5F, 1.5F}, {1, 0, 0}}).empty());
}

TEST_F(ARay, ThatStartsInsideOrOnAFaceEntersAtNought) {
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

TEST_F(ARay, ThatIsNotFiniteOrGoesBackIsAnErrorAndLeavesTheHits) {
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

TEST_F(ARay, HitsTheProxyOfTheLeastIndexFirstWhereDistancesAreEqual) {
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
