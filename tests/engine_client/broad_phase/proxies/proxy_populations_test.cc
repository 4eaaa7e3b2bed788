// Proxies that the broad phase does not search must not change the results.
#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <vector>

#include "sweepstake/broad_phase.h"
#include "sweepstake/proxy_set.h"
#include "tests/engine_client/broad_phase/proxies/proxy_game.h"

namespace sweepstake {
namespace {

using test_support::kTouching;
using test_support::kUnit;

constexpr Aabb kFarAway = {{9, 9, 9}, {10, 10, 10}};
// Debris collides with everything except debris.
constexpr CollisionFilter kDebris = {.category = 4, .mask = ~4U};

// A set whose pairs are found by brute force.
class Populations : public testing::Test {
 protected:
  std::vector<OverlapPair> Resolve() {
    backend_->Build(proxies_.moving_boxes());
    found_.Clear();
    backend_->FindPairs(found_);
    const auto pairs = proxies_.Resolve(found_.pairs());
    return {pairs.begin(), pairs.end()};
  }
  // Returns the number of boxes that the broad phase searches.
  size_t searched_count() const { return proxies_.moving_boxes().size(); }
  bool AnyEvents() const { return !proxies_.added().empty() || !proxies_.removed().empty(); }

  ProxySet proxies_{{.pair_events = true}};
  std::unique_ptr<BroadPhase> backend_ = std::move(*MakeBroadPhase("BruteForce"));
  PairBuffer found_;
};

TEST_F(Populations, DebrisThatIgnoresItselfIsNotSearched) {
  std::vector<ProxyHandle> debris(1000);
  const ProxyOptions options{.filter = kDebris};
  proxies_.AddMany(std::vector<Aabb>(1000, kUnit), std::span(&options, 1), debris);
  const ProxyHandle player = proxies_.Add(kTouching);
  EXPECT_EQ(searched_count(), 1U);
  EXPECT_EQ(Resolve().size(), 1000U);  // each one with the player
  EXPECT_EQ(found_.size(), 0U);
  ASSERT_TRUE(proxies_.SetFilter(debris[3], {}));
  EXPECT_EQ(searched_count(), 2U);
  EXPECT_EQ(proxies_.moving_boxes()[1], kUnit);
  EXPECT_EQ(proxies_.handle(debris[3].index), debris[3]);
  EXPECT_EQ(Resolve().size(), 1000U + 999U);
  EXPECT_EQ(proxies_.added().size(), 999U);
  EXPECT_EQ(proxies_.moving_count(), 1001U);
  ASSERT_TRUE(proxies_.RemoveMany(debris));
  EXPECT_FALSE(proxies_.is_alive(debris[0]));
  EXPECT_TRUE(proxies_.is_alive(player));
  EXPECT_FALSE(proxies_.RemoveMany(std::array{player, debris[0]}));
  EXPECT_TRUE(proxies_.is_alive(player));
}

TEST_F(Populations, PairsAreFilteredAfterTheSearchIfNoGroupIsFree) {
  std::vector<ProxyHandle> handles;
  for (uint32_t kind = 0; kind < 16; ++kind) {
    // Each kind matches all other kinds, so that no two fit into one group.
    handles.push_back(proxies_.Add(kUnit, {.filter = {1U << kind, ~(1U << kind)}}));
    handles.push_back(proxies_.Add(kUnit, {.filter = {1U << kind, ~(1U << kind)}}));
  }
  EXPECT_EQ(searched_count(), 2 * (16U - 7U));
  EXPECT_EQ(Resolve().size(), 32U * 31 / 2 - 16);
}

TEST_F(Populations, ProxiesThatMatchNothingUseNoGroup) {
  for (uint32_t k = 0; k < 20; ++k) proxies_.Add(kUnit, {.filter = {1U << k, 0}});
  for (uint32_t k = 0; k < 20; ++k) proxies_.Add(kUnit, {.filter = {0, 1U << k}});
  EXPECT_EQ(searched_count(), 0U);
  EXPECT_TRUE(Resolve().empty());
}

TEST_F(Populations, AProxyKeepsItsHandleWhenItBecomesStaticOrMoving) {
  for (const bool added_as_static : {false, true}) {
    const ProxyHandle other = proxies_.Add(kTouching, {.is_static = true});
    const ProxyHandle handle = proxies_.Add(kUnit, {.is_static = added_as_static, .user = 7});
    for (const bool is_static : {true, false, true, false}) {
      ASSERT_TRUE(proxies_.SetStatic(handle, is_static));
      EXPECT_EQ(proxies_.options(handle)->is_static, is_static);
      EXPECT_EQ(proxies_.options(handle)->user, 7U);
      EXPECT_EQ(proxies_.handle(handle.index), handle);
      EXPECT_EQ(proxies_.static_count(), is_static ? 2U : 1U);
      EXPECT_EQ(Resolve().size(), is_static ? 0U : 1U);
    }
    EXPECT_EQ(searched_count(), added_as_static ? 0U : 1U);
    ASSERT_TRUE(proxies_.Remove(handle) && proxies_.Remove(other));
    Resolve();
  }
  EXPECT_FALSE(proxies_.SetStatic({}, true));
}

TEST_F(Populations, FormerStaticProxiesFormPairs) {
  const ProxyHandle a = proxies_.Add(kUnit, {.is_static = true});
  const ProxyHandle b = proxies_.Add(kTouching, {.is_static = true});
  EXPECT_TRUE(Resolve().empty());
  ASSERT_TRUE(proxies_.SetStatic(a, false));
  EXPECT_EQ(Resolve(), (std::vector{OverlapPair{a.index, b.index}}));
  ASSERT_TRUE(proxies_.SetStatic(b, false));
  EXPECT_EQ(Resolve(), (std::vector{OverlapPair{a.index, b.index}}));
  EXPECT_FALSE(AnyEvents());
}

TEST_F(Populations, SleepersKeepTheirPairsWithoutASearch) {
  const ProxyHandle a = proxies_.Add(kUnit);
  const ProxyHandle b = proxies_.Add(kTouching);
  proxies_.Add(kTouching, {.is_static = true});
  EXPECT_EQ(Resolve().size(), 3U);
  ASSERT_TRUE(proxies_.SetSleeping(a, true) && proxies_.SetSleeping(b, true));
  EXPECT_EQ(searched_count(), 0U);
  EXPECT_EQ(Resolve().size(), 3U);
  EXPECT_FALSE(AnyEvents());
  const uint64_t refits = proxies_.refit_count();
  EXPECT_EQ(Resolve().size(), 3U);
  ASSERT_TRUE(proxies_.Move(a, kUnit));  // the box does not change
  EXPECT_TRUE(proxies_.is_sleeping(a));
  EXPECT_EQ(Resolve().size(), 3U);
  EXPECT_EQ(proxies_.refit_count(), refits);
  const ProxyHandle visitor = proxies_.Add(kUnit);
  EXPECT_EQ(Resolve().size(), 6U);
  EXPECT_EQ(proxies_.added().size(), 3U);
  EXPECT_EQ(proxies_.refit_count(), refits + 1);  // the tree of the visitor only
  ASSERT_TRUE(proxies_.Remove(visitor) && proxies_.Move(a, kFarAway));
  EXPECT_FALSE(proxies_.is_sleeping(a));
  EXPECT_TRUE(proxies_.is_sleeping(b));
  EXPECT_EQ(Resolve().size(), 1U);
}

TEST_F(Populations, SleepersLeaveNoGapsInTheBoxesOfTheBroadPhase) {
  std::vector<ProxyHandle> handles;
  for (int k = 0; k < 64; ++k) handles.push_back(proxies_.Add(kUnit));
  ASSERT_TRUE(proxies_.Remove(handles[0]) && proxies_.Remove(handles[1]));
  for (size_t k = 2; k < 60; ++k) ASSERT_TRUE(proxies_.SetSleeping(handles[k], true));
  EXPECT_EQ(searched_count(), 4U);
  for (size_t k = 2; k < 64; ++k) EXPECT_EQ(*proxies_.box(handles[k]), kUnit);
  EXPECT_EQ(Resolve().size(), 62U * 61 / 2);
}

TEST_F(Populations, AProxyCanGetTheBoxOfAnotherOne) {
  const ProxyHandle first = proxies_.Add(kFarAway);
  const ProxyHandle second = proxies_.Add(kUnit);
  ASSERT_TRUE(proxies_.SetSleeping(second, true) && proxies_.SetSleeping(first, true));
  // `second` wakes and takes the row of `first`.
  ASSERT_TRUE(proxies_.Move(second, *proxies_.box(first)));
  EXPECT_EQ(*proxies_.box(second), kFarAway);
  for (int k = 0; k < 200; ++k) {
    EXPECT_EQ(*proxies_.box(proxies_.Add(*proxies_.box(first))), kFarAway);
  }
}

TEST_F(Populations, StaticProxiesCannotSleep) {
  const ProxyHandle wall = proxies_.Add(kUnit, {.is_static = true});
  ASSERT_TRUE(proxies_.SetSleeping(wall, true));
  EXPECT_FALSE(proxies_.is_sleeping(wall));
  EXPECT_TRUE(proxies_.options(wall)->is_static);
  EXPECT_FALSE(proxies_.SetSleeping({}, true));
  EXPECT_FALSE(proxies_.is_sleeping({}));
}

TEST_F(Populations, SleepingDebrisFormsNoPairsWithItself) {
  std::vector<ProxyHandle> debris(200);
  const ProxyOptions options{.filter = kDebris};
  proxies_.AddMany(std::vector<Aabb>(200, kUnit), std::span(&options, 1), debris);
  for (const ProxyHandle piece : debris) ASSERT_TRUE(proxies_.SetSleeping(piece, true));
  const ProxyHandle player = proxies_.Add(kUnit);
  EXPECT_EQ(Resolve().size(), 200U);
  ASSERT_TRUE(proxies_.SetSleeping(player, true));
  EXPECT_EQ(Resolve().size(), 200U);
  EXPECT_FALSE(AnyEvents());
}

TEST_F(Populations, PairsStayWhenTheOriginIsShifted) {
  std::vector<ProxyHandle> handles;
  for (int k = 0; k < 60; ++k) {
    const auto at = static_cast<float>(k);
    handles.push_back(proxies_.Add(
        {{at, at, at}, {at + 1, at + 1, at + 1}},
        {.filter = k % 5 == 0 ? kDebris : CollisionFilter{}, .is_static = k % 3 == 0}));
    ASSERT_TRUE(proxies_.SetSleeping(handles.back(), k % 4 == 0));
  }
  const ProxyHandle broken = proxies_.Add({{1, 0, 0}, {0, 1, 1}});
  const auto before = Resolve();
  EXPECT_GE(before.size(), 50U);
  const float offset[3] = {1024, -512, 0.5F};
  ASSERT_TRUE(proxies_.ShiftOrigin(offset).ok());
  EXPECT_EQ(Resolve(), before);
  EXPECT_FALSE(AnyEvents());
  EXPECT_EQ(*proxies_.box(handles[2]), (Aabb{{-1022, 514, 1.5F}, {-1021, 515, 2.5F}}));
  EXPECT_TRUE(proxies_.is_sleeping(handles[4]));
  EXPECT_EQ(*proxies_.box(broken), (Aabb{{1, 0, 0}, {0, 1, 1}}));
}

TEST_F(Populations, AnInfiniteOriginShiftChangesNothing) {
  const ProxyHandle handle = proxies_.Add(kUnit);
  const ProxyHandle wall = proxies_.Add(kUnit, {.is_static = true});
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (const float beyond : {kInfinity, -kInfinity, std::numeric_limits<float>::quiet_NaN()}) {
    for (size_t axis = 0; axis < 3; ++axis) {
      float offset[3] = {1, 1, 1};
      offset[axis] = beyond;
      EXPECT_EQ(proxies_.ShiftOrigin(offset).code(), StatusCode::kInvalidArgument);
      EXPECT_EQ(*proxies_.box(handle), kUnit);
      EXPECT_EQ(*proxies_.box(wall), kUnit);
    }
  }
}

TEST_F(Populations, BoxesShiftedBeyondTheLargestFloatAreInvalidUntilMoved) {
  constexpr float kLargest = std::numeric_limits<float>::max();
  const ProxyHandle above = proxies_.Add({{0, 0, 0}, {kLargest / 2, 1, 1}});
  const ProxyHandle below = proxies_.Add({{0, -kLargest / 2, 0}, {1, 1, 1}});
  const ProxyHandle within = proxies_.Add(kUnit);
  EXPECT_EQ(Resolve().size(), 3U);
  const float offset[3] = {-kLargest, kLargest, 0};
  ASSERT_TRUE(proxies_.ShiftOrigin(offset).ok());
  EXPECT_FALSE(IsValid(*proxies_.box(above)));
  EXPECT_FALSE(IsValid(*proxies_.box(below)));
  EXPECT_EQ(*proxies_.box(within), (Aabb{{kLargest, -kLargest, 0}, {kLargest, -kLargest, 1}}));
  EXPECT_TRUE(Resolve().empty());
  ASSERT_TRUE(proxies_.Move(above, *proxies_.box(within)));
  ASSERT_TRUE(proxies_.Move(below, *proxies_.box(within)));
  EXPECT_EQ(Resolve().size(), 3U);
}

}  // namespace
}  // namespace sweepstake
