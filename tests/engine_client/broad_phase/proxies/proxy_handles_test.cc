// A handle identifies its proxy, and a stale handle never identifies another proxy.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "engine_client/broad_phase/proxies/proxy_table.h"
#include "sweepstake/proxy_set.h"
#include "tests/engine_client/broad_phase/proxies/proxy_game.h"

namespace sweepstake {
namespace {

using test_support::kUnit;

constexpr Aabb kOther = {{5, 5, 5}, {6, 6, 6}};

void ExpectNothingBehind(ProxySet& proxies, ProxyHandle handle) {
  EXPECT_FALSE(proxies.is_alive(handle));
  EXPECT_FALSE(proxies.Remove(handle));
  EXPECT_FALSE(proxies.Move(handle, kUnit));
  EXPECT_FALSE(proxies.Move(std::array{handle}, std::array{kUnit}));
  EXPECT_FALSE(proxies.SetFilter(handle, {}));
  EXPECT_FALSE(proxies.SetUser(handle, 1));
  EXPECT_EQ(proxies.box(handle), nullptr);
  EXPECT_EQ(proxies.options(handle), std::nullopt);
}

class ProxiesOfEachKind : public testing::TestWithParam<bool> {
 protected:
  ProxyHandle Add(const Aabb& box, uint64_t user = 0) {
    return proxies_.Add(box, {.is_static = GetParam(), .user = user});
  }
  size_t count() const { return GetParam() ? proxies_.static_count() : proxies_.moving_count(); }

  ProxySet proxies_;
};

TEST_P(ProxiesOfEachKind, HaveTheAddedBoxAndOptions) {
  const ProxyOptions options{{4, 7}, GetParam(), 0x123456789abcdef0U};
  const ProxyHandle handle = proxies_.Add(kUnit, options);
  EXPECT_FALSE(handle.is_null());
  EXPECT_TRUE(proxies_.is_alive(handle));
  EXPECT_EQ(*proxies_.box(handle), kUnit);
  EXPECT_EQ(proxies_.options(handle), options);
  EXPECT_EQ(proxies_.handle(handle.index), handle);
  EXPECT_EQ((handle.index & kStaticProxyBit) != 0, GetParam());
  EXPECT_EQ(proxies_.moving_count() + proxies_.static_count(), 1U);
}

TEST_P(ProxiesOfEachKind, CanChangeBoxFilterAndUserData) {
  const ProxyHandle handle = Add(kUnit);
  EXPECT_TRUE(proxies_.Move(handle, kOther));
  EXPECT_TRUE(proxies_.SetFilter(handle, {8, 9}));
  EXPECT_TRUE(proxies_.SetUser(handle, 77));
  EXPECT_EQ(*proxies_.box(handle), kOther);
  EXPECT_EQ(proxies_.options(handle), (ProxyOptions{{8, 9}, GetParam(), 77}));
}

TEST_P(ProxiesOfEachKind, LeaveTheirSlotToTheNextWithAnotherHandle) {
  const ProxyHandle first = Add(kUnit, 1);
  EXPECT_TRUE(proxies_.Remove(first));
  ExpectNothingBehind(proxies_, first);
  EXPECT_TRUE(proxies_.handle(first.index).is_null());
  const ProxyHandle second = Add(kOther, 2);
  EXPECT_EQ(second.index, first.index);
  EXPECT_NE(second, first);
  ExpectNothingBehind(proxies_, first);
  EXPECT_EQ(proxies_.options(second)->user, 2U);
  EXPECT_EQ(*proxies_.box(second), kOther);
  EXPECT_EQ(count(), 1U);
}

TEST_P(ProxiesOfEachKind, AreNotFoundByInvalidHandles) {
  const ProxyHandle handle = Add(kUnit);
  ExpectNothingBehind(proxies_, {});
  ExpectNothingBehind(proxies_, {handle.index, 0});
  ExpectNothingBehind(proxies_, {handle.index, handle.generation + 1});
  ExpectNothingBehind(proxies_, {handle.index + 1, 1});
  ExpectNothingBehind(proxies_, {handle.index ^ kStaticProxyBit, handle.generation});
  ExpectNothingBehind(proxies_, {~0U, 1});
  EXPECT_TRUE(proxies_.handle(12345).is_null());
}

TEST_P(ProxiesOfEachKind, MoveAllOrNoneOfABatch) {
  const ProxyHandle a = Add(kUnit);
  const ProxyHandle b = Add(kUnit);
  EXPECT_TRUE(proxies_.Move(std::array{a, b}, std::array{kOther, kOther}));
  EXPECT_EQ(*proxies_.box(b), kOther);
  EXPECT_TRUE(proxies_.Remove(b));
  EXPECT_FALSE(proxies_.Move(std::array{a, b}, std::array{kUnit, kUnit}));
  EXPECT_EQ(*proxies_.box(a), kOther);
}

TEST_P(ProxiesOfEachKind, GetTheLowestFreeId) {
  std::vector<ProxyHandle> handles;
  for (int k = 0; k < 5000; ++k) handles.push_back(Add(kUnit));
  for (const size_t k : {4321U, 7U, 1500U, 1400U}) ASSERT_TRUE(proxies_.Remove(handles[k]));
  for (const size_t k : {7U, 1400U, 1500U, 4321U}) {
    const ProxyHandle next = Add(kUnit);
    EXPECT_EQ(next.index, handles[k].index);
    EXPECT_NE(next, handles[k]);
  }
  EXPECT_EQ(Add(kUnit).index, handles.back().index + 1);
}

INSTANTIATE_TEST_SUITE_P(, ProxiesOfEachKind, testing::Bool(),
                         [](const auto& test) { return test.param ? "Static" : "Moving"; });

TEST(MovingBoxes, AreThoseOfLivingMovingProxies) {
  ProxySet proxies;
  const ProxyHandle a = proxies.Add(kUnit);
  proxies.Add(kOther);
  proxies.Add(kUnit, {.is_static = true});
  EXPECT_EQ(proxies.moving_boxes().size(), 2U);
  EXPECT_TRUE(proxies.Remove(a));
  ASSERT_EQ(proxies.moving_boxes().size(), 1U);
  EXPECT_EQ(proxies.moving_boxes()[0], kOther);
}

// A broad phase that uses temporal coherence would do more work if other boxes moved too.
TEST(MovingBoxes, ChangeInOnePlaceWhenAProxyReplacesAnother) {
  ProxySet proxies;
  std::vector<ProxyHandle> handles;
  for (int k = 0; k < 64; ++k) handles.push_back(proxies.Add(kUnit));
  ASSERT_TRUE(proxies.Remove(handles[10]) && proxies.Remove(handles[20]));
  EXPECT_EQ(proxies.moving_boxes().size(), 64U);
  EXPECT_FALSE(IsValid(proxies.moving_boxes()[20]));
  proxies.Add(kOther);
  EXPECT_EQ(proxies.moving_boxes()[10], kOther);
  proxies.Add(kOther);
  EXPECT_EQ(proxies.moving_boxes()[20], kOther);
  EXPECT_EQ(std::ranges::count(proxies.moving_boxes(), kUnit), 62);
}

TEST(Generations, BeginAtOneAgainAfterTheLast) {
  EXPECT_EQ(NextGeneration(0), 1U);
  EXPECT_EQ(NextGeneration(~0U - 1), ~0U);
  EXPECT_EQ(NextGeneration(~0U), 1U);
}

TEST(Handles, AreNeverReusedInALongGame) {
  test_support::ProxyGame game({}, 31);
  std::set<ProxyHandle> seen;
  for (int frame = 0; frame < 500; ++frame) {
    game.Step();
    for (const auto& proxy : game.listed) {
      ASSERT_TRUE(game.proxies.is_alive(proxy.handle));
      ASSERT_EQ(game.proxies.options(proxy.handle), proxy.options);
      seen.insert(proxy.handle);
    }
    for (const ProxyHandle handle : game.gone) ASSERT_FALSE(game.proxies.is_alive(handle));
  }
  EXPECT_FALSE(game.failed);
  EXPECT_GE(seen.size(), game.listed.size() + 200);
}

}  // namespace
}  // namespace sweepstake
