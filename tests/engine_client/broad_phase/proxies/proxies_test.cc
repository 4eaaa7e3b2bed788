// Compares proxies with the definitions, for every backend and while arms are switched: pairs by
// filter and kind, and events as the differences of two frames.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <memory>
#include <tuple>

#include "engine_client/scene/box_scenes.h"
#include "sweepstake/adaptive_broad_phase.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/proxy_set.h"
#include "tests/engine_client/broad_phase/each_simd_target.h"
#include "tests/engine_client/broad_phase/proxies/proxy_game.h"
#include "tests/support/allocation_counter.h"

namespace sweepstake {
namespace {

using test_support::AsHandles;
using test_support::kTouching;
using test_support::kUnit;
using test_support::PairsByDefinition;
using test_support::ProxyGame;
using test_support::ProxyPairs;

ProxyPairs Without(const ProxyPairs& pairs, const ProxyPairs& others) {
  ProxyPairs left;
  std::ranges::set_difference(pairs, others, std::inserter(left, left.end()));
  return left;
}

// Runs the frames of one backend.
class Frames {
 public:
  explicit Frames(std::string_view name, Executor* executor = nullptr)
      : backend_(std::move(*MakeBroadPhase(name, {executor}))) {}

  std::span<const OverlapPair> Find(std::span<const Aabb> boxes) {
    built_ ? backend_->Update(boxes) : backend_->Build(boxes);
    built_ = true;
    pairs_.Clear();
    backend_->FindPairs(pairs_);
    return pairs_.pairs();
  }

 private:
  std::unique_ptr<BroadPhase> backend_;
  PairBuffer pairs_;
  bool built_ = false;
};

// Runs frames and compares each with the definitions.
class Judge {
 public:
  explicit Judge(ProxyGame& game) : game_(game) {}

  // REQUIRES: the game's set has pair events.
  void ExpectRight(std::span<const OverlapPair> pairs) {
    ASSERT_TRUE(std::ranges::is_sorted(pairs));
    bool doubled = false;
    const ProxyPairs found = AsHandles(game_.proxies, pairs, doubled);
    const ProxyPairs expected = PairsByDefinition(game_.listed);
    ASSERT_FALSE(doubled);
    ASSERT_EQ(found, expected);
    ExpectEvents(game_.proxies.added(), Without(expected, before_));
    ExpectEvents(game_.proxies.removed(), Without(before_, expected));
    before_ = expected;
    ASSERT_FALSE(game_.failed);
  }

 private:
  static void ExpectEvents(std::span<const ProxyPair> events, const ProxyPairs& expected) {
    ASSERT_EQ(ProxyPairs(events.begin(), events.end()), expected);
    ASSERT_EQ(events.size(), expected.size());
    ASSERT_TRUE(std::ranges::is_sorted(events, [](const ProxyPair& a, const ProxyPair& b) {
      return std::pair(a.a.index, a.b.index) < std::pair(b.a.index, b.b.index);
    }));
  }

  ProxyGame& game_;
  ProxyPairs before_;
};

class Proxies : public testing::TestWithParam<std::string_view> {};

TEST_P(Proxies, HaveThePairsAndEventsOfTheDefinition) {
  ProxyGame game({.pair_events = true}, 4711);
  Judge judge(game);
  Frames frames(GetParam());
  game.AddSome(120, 60);
  for (int frame = 0; frame < 300; ++frame, game.Step()) {
    judge.ExpectRight(game.proxies.Resolve(frames.Find(game.proxies.moving_boxes())));
    if (HasFatalFailure()) FAIL() << "in frame " << frame;
  }
}

TEST_P(Proxies, AreCorrectFromManySeedsAndFromAnEmptySet) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    ProxyGame game({.pair_events = true}, seed, 3);
    Judge judge(game);
    Frames frames(GetParam());
    for (int frame = 0; frame < 40; ++frame, game.Step()) {
      judge.ExpectRight(game.proxies.Resolve(frames.Find(game.proxies.moving_boxes())));
      if (HasFatalFailure()) FAIL() << "with seed " << seed << " in frame " << frame;
    }
  }
}

TEST_P(Proxies, WithoutEventsHaveTheSamePairsInTheOrderOfTheBackend) {
  ProxyGame game({}, 12);
  Frames frames(GetParam());
  game.AddSome(100, 50);
  for (int frame = 0; frame < 60; ++frame, game.Step()) {
    bool doubled = false;
    const auto pairs = game.proxies.Resolve(frames.Find(game.proxies.moving_boxes()));
    ASSERT_EQ(AsHandles(game.proxies, pairs, doubled), PairsByDefinition(game.listed)) << frame;
    ASSERT_FALSE(doubled);
    ASSERT_TRUE(game.proxies.added().empty() && game.proxies.removed().empty());
  }
}

INSTANTIATE_TEST_SUITE_P(WithEveryBackend, Proxies,
                         testing::ValuesIn(BroadPhaseNames().begin(), BroadPhaseNames().end()),
                         [](const auto& test) { return std::string(test.param); });

TEST(ProxiesOverAnAdaptiveBroadPhase, HaveCorrectPairsAndEventsWhileArmsAreSwitched) {
  ProxyGame game({.pair_events = true}, 99);
  Judge judge(game);
  AdaptiveOptions by_hand;
  by_hand.mode = Mode::kManual;
  auto adaptive = std::move(*AdaptiveBroadPhase::Create(by_hand, nullptr));
  game.AddSome(120, 60);
  for (int frame = 0; frame < 280; ++frame, game.Step()) {
    const size_t arm = static_cast<size_t>(frame) * 5 / 7 % adaptive->arms().size();
    ASSERT_TRUE(adaptive->SelectArm(adaptive->arms()[arm]).ok());
    adaptive->BeginFrame();
    judge.ExpectRight(game.proxies.Resolve(adaptive->FindPairs(game.proxies.moving_boxes())));
    if (HasFatalFailure()) FAIL() << "in frame " << frame;
    adaptive->EndFrame({1'000'000, 0});
  }
  EXPECT_GE(adaptive->switch_epoch(), 190U);
}

TEST(ProxiesInALargeScene, HaveTheSamePairSequenceWithAnyNumberOfThreads) {
  const auto pool_of_two = MakeThreadPool(2);
  const auto pool_of_three = MakeThreadPool(3);
  std::vector<std::vector<OverlapPair>> outcomes;
  const auto play = [&](Executor* executor) {
    ProxyGame game({.executor = executor}, 5, 22);
    Frames frames("KDTree", executor);
    game.AddSome(3000, 6000);
    game.Add({{0, 0, 0}, {22, 22, 22}}, {});  // near more static leaves than fit in a list
    for (int frame = 0; frame < 3; ++frame, game.Step()) {
      const auto pairs = game.proxies.Resolve(frames.Find(game.proxies.moving_boxes()));
      if (outcomes.size() < 3) {
        bool doubled = false;
        EXPECT_EQ(AsHandles(game.proxies, pairs, doubled), PairsByDefinition(game.listed));
        EXPECT_FALSE(doubled);
        outcomes.emplace_back(pairs.begin(), pairs.end());
      }
      EXPECT_TRUE(std::ranges::equal(pairs, outcomes[static_cast<size_t>(frame)]));
    }
  };
  play(nullptr);
  play(pool_of_two.get());
  play(pool_of_three.get());
}

TEST(ProxiesOnEachInstructionSet, HaveThePairsOfTheDefinition) {
  test_support::OnEachSimdTarget([] {
    ProxyGame game({.pair_events = true}, 8);
    Judge judge(game);
    Frames frames("SAP");
    game.AddSome(200, 150);
    for (int frame = 0; frame < 10 && !HasFatalFailure(); ++frame, game.Step()) {
      judge.ExpectRight(game.proxies.Resolve(frames.Find(game.proxies.moving_boxes())));
    }
  });
}

TEST(ResolvedPairs, AreTheBackendsBufferIfThereIsNothingToFilter) {
  ProxySet proxies;
  Frames frames("BruteForce");
  proxies.Add(kUnit);
  proxies.Add(kTouching);
  const auto found = frames.Find(proxies.moving_boxes());
  EXPECT_EQ(proxies.Resolve(found).data(), found.data());
}

TEST(ResolvedPairs, NeedBothFiltersToPass) {
  ProxySet proxies;
  Frames frames("BruteForce");
  const ProxyHandle a = proxies.Add(kUnit, {.filter = {1, 2}});
  const ProxyHandle b = proxies.Add(kTouching, {.filter = {2, 4}});
  const auto resolve = [&] { return proxies.Resolve(frames.Find(proxies.moving_boxes())).size(); };
  EXPECT_EQ(resolve(), 0U);
  EXPECT_TRUE(proxies.SetFilter(b, {2, 5}));
  EXPECT_EQ(resolve(), 1U);
  EXPECT_TRUE(proxies.SetFilter(a, {1, 0}));
  EXPECT_EQ(resolve(), 0U);
}

// The slot is reused between two frames, so that the indices do not change.
TEST(PairEvents, DistinguishTheOldAndTheNewProxyOfASlot) {
  ProxySet proxies({.pair_events = true});
  Frames frames("BruteForce");
  for (const bool is_static : {false, true}) {
    const ProxyHandle a = proxies.Add(kUnit);
    const ProxyHandle b = proxies.Add(kTouching, {.is_static = is_static});
    proxies.Resolve(frames.Find(proxies.moving_boxes()));
    ASSERT_EQ(proxies.added().size(), 1U);
    ASSERT_TRUE(proxies.Remove(b));
    ASSERT_TRUE(proxies.Remove(proxies.Add(kTouching, {.is_static = is_static})));
    const ProxyHandle c = proxies.Add(kTouching, {.is_static = is_static});
    ASSERT_EQ(c.index, b.index);
    proxies.Resolve(frames.Find(proxies.moving_boxes()));
    ASSERT_EQ(proxies.removed().size(), 1U);
    EXPECT_EQ(proxies.removed()[0], (ProxyPair{a, b}));
    ASSERT_EQ(proxies.added().size(), 1U);
    EXPECT_EQ(proxies.added()[0], (ProxyPair{a, c}));
    ASSERT_TRUE(proxies.Remove(a) && proxies.Remove(c));
    proxies.Resolve(frames.Find(proxies.moving_boxes()));
    ASSERT_EQ(proxies.removed().size(), 1U);
    EXPECT_EQ(proxies.removed()[0], (ProxyPair{a, c}));
  }
}

// The second box moves along one axis, on one side of the first: away from it, back, and beyond the
// margin of the events.
class PairEventsAlongAnAxis : public testing::TestWithParam<std::tuple<size_t, float>> {};

TEST_P(PairEventsAlongAnAxis, EndAPairOnlyBeyondTheMargin) {
  const size_t axis = std::get<0>(GetParam());
  const float side = std::get<1>(GetParam());
  ProxySet proxies({.pair_events = true, .event_margin = 0.5F});
  Frames frames("BruteForce");
  const auto at = [axis, side](float x) {
    Aabb box = kUnit;
    box.min[axis] = side * x;
    box.max[axis] = side * x + 1;
    return box;
  };
  const ProxyHandle a = proxies.Add(at(0));
  const ProxyHandle b = proxies.Add(at(1.25F));
  const auto resolve = [&](float x) {
    EXPECT_TRUE(proxies.Move(b, at(x)));
    return proxies.Resolve(frames.Find(proxies.moving_boxes())).size();
  };
  const auto events = [&] { return std::pair(proxies.added().size(), proxies.removed().size()); };
  EXPECT_EQ(resolve(1.25F), 0U);  // the boxes are near, but their pair has not begun
  EXPECT_EQ(events(), std::pair(size_t{0}, size_t{0}));
  EXPECT_EQ(resolve(1), 1U);
  EXPECT_EQ(events(), std::pair(size_t{1}, size_t{0}));
  EXPECT_EQ(resolve(1.5F), 0U);  // the pairs, unlike their events, have no margin
  EXPECT_EQ(events(), std::pair(size_t{0}, size_t{0}));
  EXPECT_EQ(resolve(1), 1U);
  EXPECT_EQ(events(), std::pair(size_t{0}, size_t{0}));
  EXPECT_EQ(resolve(1.5078125F), 0U);
  ASSERT_EQ(events(), std::pair(size_t{0}, size_t{1}));
  EXPECT_EQ(proxies.removed()[0], (ProxyPair{a, b}));
  EXPECT_EQ(resolve(1.5F), 0U);
  EXPECT_EQ(events(), std::pair(size_t{0}, size_t{0}));
}

INSTANTIATE_TEST_SUITE_P(EachWay, PairEventsAlongAnAxis,
                         testing::Combine(testing::Values(0U, 1U, 2U),
                                          testing::Values(1.0F, -1.0F)));

TEST(PairEventsWithAMargin, UseNoMarginIfItIsNegativeOrNaN) {
  for (const float margin : {-1.0F, std::numeric_limits<float>::quiet_NaN()}) {
    ProxySet proxies({.pair_events = true, .event_margin = margin});
    Frames frames("BruteForce");
    const ProxyHandle ball = proxies.Add(kUnit);
    proxies.Add(kTouching);
    proxies.Resolve(frames.Find(proxies.moving_boxes()));
    EXPECT_EQ(proxies.added().size(), 1U);
    std::vector<std::byte> snapshot(proxies.snapshot_bytes());
    ASSERT_TRUE(proxies.Save(snapshot).ok());
    EXPECT_TRUE(ProxySet({.pair_events = true}).Restore(snapshot).ok());
    ASSERT_TRUE(proxies.Move(ball, {{9, 9, 9}, {10, 10, 10}}));
    proxies.Resolve(frames.Find(proxies.moving_boxes()));
    EXPECT_EQ(proxies.removed().size(), 1U);
  }
}

TEST(PairEventsWithAMargin, EndAPairAtOnceIfAProxyIsRemovedOrFiltered) {
  constexpr Aabb kNear = {{1.25F, 0, 0}, {2, 1, 1}};
  Frames frames("BruteForce");
  const auto ended_after = [&](const auto& change) {
    ProxySet proxies({.pair_events = true, .event_margin = 0.5F});
    const ProxyHandle a = proxies.Add(kUnit);
    const ProxyHandle b = proxies.Add(kTouching, {.is_static = true});
    proxies.Resolve(frames.Find(proxies.moving_boxes()));
    EXPECT_TRUE(proxies.Move(b, kNear));
    change(proxies, a, b);
    proxies.Resolve(frames.Find(proxies.moving_boxes()));
    EXPECT_TRUE(proxies.added().empty());
    return proxies.removed().size() == 1 && proxies.removed()[0] == ProxyPair{a, b};
  };
  EXPECT_FALSE(ended_after([](ProxySet&, ProxyHandle, ProxyHandle) {}));
  EXPECT_TRUE(ended_after([](ProxySet& set, ProxyHandle a, ProxyHandle) { set.Remove(a); }));
  EXPECT_TRUE(ended_after([](ProxySet& set, ProxyHandle a, ProxyHandle) {
    set.Remove(a);
    set.Add(kUnit);  // in the same slot, at the same position
  }));
  EXPECT_TRUE(ended_after([](ProxySet& set, ProxyHandle a, ProxyHandle) {
    set.SetFilter(a, {1, 0});
  }));
  EXPECT_TRUE(
      ended_after([](ProxySet& set, ProxyHandle a, ProxyHandle) { set.SetStatic(a, true); }));
  EXPECT_TRUE(ended_after([](ProxySet& set, ProxyHandle, ProxyHandle b) {
    set.Move(b, {{1, 0, 0}, {0, 1, 1}});
  }));
}

// Bullet passes the boxes of static objects again in each step.
TEST(ProxiesWhoseBoxesAreSentAgain, CauseNoRefitAndNoEvents) {
  ProxySet proxies({.pair_events = true});
  Frames frames("BruteForce");
  const Aabb unordered = {{1, std::numeric_limits<float>::quiet_NaN(), 1}, {2, 2, 2}};
  const std::array boxes{kUnit, kTouching, unordered};
  const std::array handles{proxies.Add(boxes[0]), proxies.Add(boxes[1], {.is_static = true}),
                           proxies.Add(boxes[2], {.is_static = true})};
  proxies.Resolve(frames.Find(proxies.moving_boxes()));
  const uint64_t refits = proxies.refit_count();
  EXPECT_GT(refits, 0U);
  ASSERT_TRUE(proxies.Move(handles, boxes) && proxies.Move(handles[1], boxes[1]));
  EXPECT_EQ(proxies.Resolve(frames.Find(proxies.moving_boxes())).size(), 1U);
  EXPECT_TRUE(proxies.added().empty() && proxies.removed().empty());
  EXPECT_EQ(proxies.refit_count(), refits);
  ASSERT_TRUE(proxies.Move(handles[1], kUnit));
  proxies.PrepareQueries();
  EXPECT_EQ(proxies.refit_count(), refits + 1);
}

// Motion, teleports, adds, removes and queries must not allocate.
TEST(ProxySetInSteadyState, AllocatesNothing) {
  ProxySet proxies({.pair_events = true});
  Frames frames("SAP");
  BoxScene scene("brownian", 800, 21);
  std::vector<ProxyHandle> handles;
  for (size_t k = 0; k < 800; ++k) {
    handles.push_back(proxies.Add(scene.boxes()[k], {.is_static = k % 4 == 0}));
  }
  std::vector<ProxyHandle> found;
  std::vector<RayHit> hits;
  found.reserve(800);
  hits.reserve(800);
  const auto play = [&](int frame_count) {
    for (int frame = 0; frame < frame_count; ++frame) {
      scene.Step();
      for (size_t k = 0; k < 800; ++k) {
        if (k % 4 != 0) proxies.Move(handles[k], scene.boxes()[k]);
      }
      const size_t again = static_cast<size_t>(frame) * 7 % 800;
      proxies.Remove(handles[again]);
      handles[again] = proxies.Add(scene.boxes()[again], {.is_static = again % 4 == 0});
      proxies.Resolve(frames.Find(proxies.moving_boxes()));
      proxies.QueryBox({{0, 0, 0}, {4, 4, 4}}, {}, found);
      EXPECT_TRUE(proxies.CastRay({{0, 4, 4}, {1, 0.1F, 0.1F}}, {}, hits).ok());
    }
  };
  play(200);
  const uint64_t allocations = test_support::ThreadAllocationCount();
  const size_t bytes = proxies.native_bytes();
  play(100);
  EXPECT_EQ(test_support::ThreadAllocationCount(), allocations);
  EXPECT_EQ(proxies.native_bytes(), bytes);
}

TEST(PairEvents, EndNoPairInASearchWithTooManyPairs) {
  const auto search = std::move(*AdaptiveBroadPhase::Create(
      {.arms = {"KDTree"}, .mode = Mode::kManual, .max_pairs = 3}, nullptr));
  ProxySet proxies({.pair_events = true});
  const ProxyHandle a = proxies.Add(kUnit);
  const ProxyHandle b = proxies.Add(kUnit);
  const auto is_resolved = [&] {
    search->BeginFrame();
    search->FindPairs(proxies);
    search->EndFrame({});
    return !search->pairs_exceeded();
  };
  EXPECT_TRUE(is_resolved());
  EXPECT_EQ(proxies.added().size(), 1U);
  for (const bool stays : {true, false}) {
    const ProxyHandle crowd[] = {proxies.Add(kUnit), proxies.Add(kUnit)};
    EXPECT_FALSE(is_resolved());
    proxies.RemoveMany(crowd);
    if (!stays) proxies.Remove(a);
    EXPECT_TRUE(is_resolved());
    EXPECT_TRUE(proxies.added().empty());
    EXPECT_EQ(proxies.removed().size(), stays ? 0U : 1U);
  }
  EXPECT_EQ(proxies.removed()[0], (ProxyPair{a, b}));
}

}  // namespace
}  // namespace sweepstake
