// The max_pairs of Resolve must end each search of the set whose pairs explode, with bounded memory
// and without lost events.
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine_client/broad_phase/common/stop_poll.h"
#include "sweepstake/adaptive_broad_phase.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/proxy_set.h"
#include "tests/engine_client/broad_phase/proxies/proxy_game.h"

namespace sweepstake {
namespace {

using test_support::kUnit;

constexpr size_t kThreads = 2;
constexpr ProxyOptions kStaticOptions{.is_static = true};
// Debris of the two kinds collides with the other kind only.
constexpr ProxyOptions kDebrisKinds[] = {{.filter = {.category = 1, .mask = 2}},
                                         {.filter = {.category = 2, .mask = 1}}};

void AddMany(ProxySet& proxies, size_t count, const ProxyOptions& options = {}) {
  for (size_t k = 0; k < count; ++k) proxies.Add(kUnit, options);
}

void AddSleeping(ProxySet& proxies, size_t count, const ProxyOptions& options = {}) {
  for (size_t k = 0; k < count; ++k) proxies.SetSleeping(proxies.Add(kUnit, options), true);
}

// Proxies in one place, and the number of their pairs.
struct Crowd {
  const char* name;
  std::function<void(ProxySet&)> add;
  size_t pair_count;
};

const Crowd kCrowds[] = {
    {"Moving", [](ProxySet& proxies) { AddMany(proxies, 5); }, 10},
    {"Sleeping", [](ProxySet& proxies) { AddSleeping(proxies, 5); }, 10},
    {"SleepingOnStatic",
     [](ProxySet& proxies) {
       AddSleeping(proxies, 1);
       AddMany(proxies, 5, kStaticOptions);
     },
     5},
    {"MovingAmongStatic",
     [](ProxySet& proxies) {
       AddMany(proxies, 3);
       AddMany(proxies, 5, kStaticOptions);
     },
     3 + 3 * 5},
    {"MovingAmongSleeping",
     [](ProxySet& proxies) {
       AddMany(proxies, 3);
       AddSleeping(proxies, 4);
     },
     3 + 3 * 4 + 6},
    {"Debris",
     [](ProxySet& proxies) {
       for (const ProxyOptions& kind : kDebrisKinds) AddMany(proxies, 5, kind);
     },
     25},
    {"SleepingDebris",
     [](ProxySet& proxies) {
       for (const ProxyOptions& kind : kDebrisKinds) AddSleeping(proxies, 5, kind);
     },
     25},
};

class EachCrowd : public testing::TestWithParam<Crowd> {
 protected:
  // Returns the number of pairs, or a text if there are more than max_pairs.
  std::string Resolve(ProxySet& proxies, uint64_t max_pairs) {
    backend_->Build(proxies.moving_boxes());
    found_.Clear();
    backend_->FindPairs(found_);
    const size_t count = proxies.Resolve(found_.pairs(), max_pairs).size();
    if (!proxies.pairs_exceeded()) return std::to_string(count);
    return count == 0 && proxies.added().empty() && proxies.removed().empty() ? "exceeded"
                                                                              : "not empty";
  }
  std::string pair_count() const { return std::to_string(GetParam().pair_count); }

 private:
  std::unique_ptr<BroadPhase> backend_ = std::move(*MakeBroadPhase("BruteForce"));
  PairBuffer found_;
};

TEST_P(EachCrowd, MayHaveExactlyTheMaximum) {
  for (const bool pair_events : {false, true}) {
    ProxySet proxies({.pair_events = pair_events});
    GetParam().add(proxies);
    // The pairs of resting proxies are found in the first frame and kept in the next one.
    for (int frame = 0; frame < 2; ++frame) {
      EXPECT_EQ(Resolve(proxies, GetParam().pair_count), pair_count());
    }
    for (int frame = 0; frame < 2; ++frame) {
      EXPECT_EQ(Resolve(proxies, GetParam().pair_count - 1), "exceeded");
    }
    EXPECT_EQ(Resolve(proxies, 0), pair_count());
  }
}

TEST_P(EachCrowd, HasAllEventsAfterFramesWithTooManyPairs) {
  ProxySet proxies({.pair_events = true});
  const ProxyHandle kept = proxies.Add({{9, 9, 9}, {10, 10, 10}});
  const ProxyHandle gone = proxies.Add({{9, 9, 9}, {10, 10, 10}});
  EXPECT_EQ(Resolve(proxies, 1), "1");
  GetParam().add(proxies);
  const uint64_t least = GetParam().pair_count;
  EXPECT_EQ(Resolve(proxies, least), "exceeded");
  proxies.Remove(gone);
  EXPECT_EQ(Resolve(proxies, least - 1), "exceeded");
  EXPECT_EQ(Resolve(proxies, least), pair_count());
  EXPECT_EQ(proxies.added().size(), least);
  ASSERT_EQ(proxies.removed().size(), 1U);
  EXPECT_EQ(proxies.removed()[0], (ProxyPair{kept, gone}));
  EXPECT_EQ(Resolve(proxies, least), pair_count());
  EXPECT_TRUE(proxies.added().empty() && proxies.removed().empty());
}

INSTANTIATE_TEST_SUITE_P(Proxies, EachCrowd, testing::ValuesIn(kCrowds),
                         [](const auto& crowd) { return crowd.param.name; });

TEST(MaxPairsOfProxies, CountsPairsThatDoNotPassTheirFilters) {
  ProxySet proxies;
  AddSleeping(proxies, 3, {.filter = {.category = 1, .mask = 1}});
  AddSleeping(proxies, 1, {.filter = {.category = 2, .mask = 2}});
  EXPECT_TRUE(proxies.Resolve({}, 5).empty());
  EXPECT_TRUE(proxies.pairs_exceeded());
  EXPECT_EQ(proxies.Resolve({}, 6).size(), 3U);
  EXPECT_FALSE(proxies.pairs_exceeded());
}

// A tree of static boxes in a row, whose leaves the set searches for each large box separately.
void AddLargeAmongStatic(ProxySet& proxies) {
  for (int k = 0; k < 300; ++k) proxies.Add({{-1e6F, -1e6F, -1e6F}, {1e6F, 1e6F, 1e6F}});
  for (int k = 0; k < 100'000; ++k) {
    const auto x = static_cast<float>(k);
    proxies.Add({{x, 0, 0}, {x + 0.5F, 1, 1}}, kStaticOptions);
  }
}

TEST(MaxPairsOfProxies, EndsEachSearchWithinBoundedMemory) {
  constexpr uint64_t kMaxPairs = 100'000;
  // A list of near leaves is checked without a stop test. A buffer doubles.
  constexpr uint64_t kMaxFound = kMaxPairs + kThreads * 3 * StopPoll::kChecksPerQuestion;
  constexpr uint64_t kMaxBytes = 2 * kMaxFound * sizeof(OverlapPair);
  const std::pair<const char*, std::function<void(ProxySet&)>> crowds[] = {
      {"sleeping", [](ProxySet& proxies) { AddSleeping(proxies, 8'000); }},
      {"seven kinds of debris",  // each collides with all others, so that there are 21 joins
       [](ProxySet& proxies) {
         for (uint32_t bit = 1; bit < 1U << 7; bit *= 2) {
           AddMany(proxies, 1'000, {.filter = {.category = bit, .mask = ~bit}});
         }
       }},
      {"large among static", AddLargeAmongStatic},
  };
  const auto pool = MakeThreadPool(kThreads);
  for (Executor* const executor : {static_cast<Executor*>(nullptr), pool.get()}) {
    for (const auto& [name, add] : crowds) {
      ProxySet proxies({.pair_events = true, .executor = executor});
      add(proxies);
      proxies.PrepareQueries();
      const uint64_t prepared_bytes = proxies.native_bytes();
      for (int frame = 0; frame < 4; ++frame) {
        EXPECT_TRUE(proxies.Resolve({}, kMaxPairs).empty());
        EXPECT_TRUE(proxies.pairs_exceeded()) << name;
        EXPECT_LE(proxies.native_bytes() - prepared_bytes, kMaxBytes) << name;
      }
    }
  }
}

TEST(MaxPairsOfProxies, AreThoseOfTheAdaptiveSearch) {
  const auto search = std::move(*AdaptiveBroadPhase::Create(
      {.arms = {"KDTree"}, .mode = Mode::kManual, .max_pairs = 6}, nullptr));
  EXPECT_EQ(search->max_pairs(), 6U);
  ProxySet proxies({.pair_events = true});
  AddMany(proxies, 2);
  const auto resolved_count = [&] {
    search->BeginFrame();
    const size_t count = search->FindPairs(proxies).size();
    search->EndFrame({});
    const bool flagged = (search->last_sample().flags & kFramePairsExceeded) != 0;
    EXPECT_EQ(flagged, search->pairs_exceeded());
    return count;
  };
  // The pairs of static proxies are found by the set, the others by the broad phase.
  for (const bool is_static : {true, false}) {
    const ProxyHandle first = proxies.Add(kUnit, {.is_static = is_static});
    EXPECT_EQ(resolved_count(), 3U);
    EXPECT_FALSE(search->pairs_exceeded());
    EXPECT_FALSE(proxies.added().empty());
    ProxyHandle crowd[3];
    for (ProxyHandle& proxy : crowd) proxy = proxies.Add(kUnit, {.is_static = is_static});
    EXPECT_EQ(resolved_count(), 0U);
    EXPECT_TRUE(search->pairs_exceeded());
    EXPECT_TRUE(proxies.pairs_exceeded());
    EXPECT_TRUE(proxies.added().empty() && proxies.removed().empty());
    proxies.RemoveMany(crowd);
    EXPECT_EQ(resolved_count(), 3U);
    EXPECT_FALSE(search->pairs_exceeded());
    EXPECT_TRUE(proxies.added().empty() && proxies.removed().empty());
    proxies.Remove(first);
    EXPECT_EQ(resolved_count(), 1U);
    EXPECT_EQ(proxies.removed().size(), 2U);
  }
}

}  // namespace
}  // namespace sweepstake
