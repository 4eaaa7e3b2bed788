// Makes the same calls to Box2D's own b2BroadPhase and to ours, and compares all results.
#include <box2d/b2_broad_phase.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "sweepstake/box2d.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/one_arm.h"
#include "tests/support/size_of_run.h"

namespace sweepstake::test_support {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// The user value of a proxy is the address of its number.
int NumberOf(const void* user_data) { return *static_cast<const int*>(user_data); }

// Collects the numbers of new pairs.
struct Pairs {
  void AddPair(void* a, void* b) { found.emplace_back(NumberOf(a), NumberOf(b)); }
  // The order of a pair depends on the ids, which differ between both broad phases.
  std::set<std::pair<int, int>> InAnyOrder() const {
    std::set<std::pair<int, int>> pairs;
    for (const auto& [a, b] : found) pairs.insert(std::minmax(a, b));
    return pairs;
  }

  std::vector<std::pair<int, int>> found = {};
};

// Collects the numbers of the proxies that a query finds.
template <typename BroadPhase>
struct Found {
  bool QueryCallback(int32 id) {
    numbers.push_back(NumberOf(broad_phase->GetUserData(id)));
    return numbers.size() < limit;
  }
  float RayCastCallback(const b2RayCastInput& /*input*/, int32 id) {
    QueryCallback(id);
    return ray_result;
  }
  std::vector<int> Sorted() {
    std::sort(numbers.begin(), numbers.end());
    return numbers;
  }

  const BroadPhase* broad_phase;
  size_t limit = std::numeric_limits<size_t>::max();
  float ray_result = -1;
  std::vector<int> numbers = {};
};

b2AABB BoxAt(float x, float y, float half = 0.5F) {
  b2AABB box;
  box.lowerBound.Set(x - half, y - half);
  box.upperBound.Set(x + half, y + half);
  return box;
}

bool AreEqual(const b2AABB& a, const b2AABB& b) {
  return a.lowerBound == b.lowerBound && a.upperBound == b.upperBound;
}

class Box2dBroadPhaseTest : public ::testing::TestWithParam<std::string_view> {
 protected:
  int32 Add(float x, float y) { return ours_.CreateProxy(BoxAt(x, y), &numbers_[next_++]); }

  std::vector<std::pair<int, int>> NewPairs() {
    Pairs pairs;
    search_->BeginFrame();
    ours_.UpdatePairs(&pairs);
    search_->EndFrame({});
    return pairs.found;
  }

  void ExpectNothingLeftOfABurst(size_t changed_count, size_t awake_count) {
    for (int i = 0; i < 100; ++i) Add(static_cast<float>(i) * 0.7F, 0);
    // More updates than until unused memory is freed, and a change, which frees that of the boxes.
    const auto play = [&] {
      for (int update = 0; update < 600; ++update) {
        for (size_t id = 0; id < changed_count; ++id) ours_.TouchProxy(static_cast<int32>(id));
        NewPairs();
      }
      ours_.DestroyProxy(ours_.CreateProxy(BoxAt(0, 100), numbers_.data()));
    };
    play();
    EXPECT_EQ(ours_.awake_count(), awake_count);
    const size_t bytes = ours_.native_bytes();
    std::vector<int32> burst(5000);
    for (size_t i = 0; i < burst.size(); ++i) {
      burst[i] = ours_.CreateProxy(BoxAt(static_cast<float>(i) * 2, 100), numbers_.data());
    }
    NewPairs();
    EXPECT_GT(ours_.native_bytes(), 10 * bytes);
    for (const int32 id : burst) ours_.DestroyProxy(id);
    play();
    EXPECT_EQ(ours_.awake_count(), awake_count);
    EXPECT_LT(ours_.native_bytes(), 2 * bytes);
  }

  const std::unique_ptr<AdaptiveBroadPhase> search_ =
      std::move(*AdaptiveBroadPhase::Create(OneArm(GetParam(), nullptr, kMaxPairs), nullptr));
  Box2dBroadPhase ours_{*search_};
  std::vector<int> numbers_ = [] {
    std::vector<int> numbers(1000);
    for (size_t i = 0; i < numbers.size(); ++i) numbers[i] = static_cast<int>(i);
    return numbers;
  }();
  size_t next_ = 0;
};

INSTANTIATE_TEST_SUITE_P(Each, Box2dBroadPhaseTest, ::testing::ValuesIn(BroadPhaseNames()),
                         [](const auto& arm) { return std::string(arm.param); });

// Both broad phases, with proxies that come, move, are touched and go at random.
class SameCallsTest : public Box2dBroadPhaseTest {
 protected:
  struct Proxy {
    int32 ours;
    int32 theirs;
    b2Vec2 place;
  };

  float Random(float low, float high) {
    return std::uniform_real_distribution<float>(low, high)(random_);
  }

  void Create() {
    if (next_ == numbers_.size()) return;
    const b2Vec2 place(Random(-20, 20), Random(-20, 20));
    const b2AABB box = BoxAt(place.x, place.y);
    int* const number = &numbers_[next_++];
    live_.push_back({ours_.CreateProxy(box, number), theirs_.CreateProxy(box, number), place});
  }

  void Destroy(size_t at) {
    ours_.DestroyProxy(live_[at].ours);
    theirs_.DestroyProxy(live_[at].theirs);
    live_.erase(live_.begin() + static_cast<std::ptrdiff_t>(at));
  }

  // Moves by less than the margin, by more, or far.
  void Move(Proxy& proxy) {
    const float reach = std::vector<float>{0.02F, 0.3F, 5}[random_() % 3];
    const b2Vec2 way(Random(-reach, reach), Random(-reach, reach));
    proxy.place += way;
    const b2AABB box = BoxAt(proxy.place.x, proxy.place.y);
    ours_.MoveProxy(proxy.ours, box, way);
    theirs_.MoveProxy(proxy.theirs, box, way);
  }

  void ExpectSamePairs() {
    Pairs theirs;
    theirs_.UpdatePairs(&theirs);
    const Pairs ours{NewPairs()};
    EXPECT_EQ(ours.InAnyOrder(), theirs.InAnyOrder());
    // Box2D reports a pair twice if one of the two was only touched.
    EXPECT_EQ(ours.found.size(), theirs.InAnyOrder().size());
    pair_count_ += ours.found.size();
  }

  void ExpectSameBoxes() {
    EXPECT_EQ(ours_.GetProxyCount(), theirs_.GetProxyCount());
    int difference_count = 0;
    for (const Proxy& a : live_) {
      const Proxy& b = live_[random_() % live_.size()];
      const bool same =
          AreEqual(ours_.GetFatAABB(a.ours), theirs_.GetFatAABB(a.theirs)) &&
          ours_.TestOverlap(a.ours, b.ours) == theirs_.TestOverlap(a.theirs, b.theirs);
      if (!same) ++difference_count;
    }
    EXPECT_EQ(difference_count, 0);
  }

  void ExpectSameQueries() {
    Found<Box2dBroadPhase> ours{&ours_};
    Found<b2BroadPhase> theirs{&theirs_};
    const b2AABB box = BoxAt(Random(-20, 20), Random(-20, 20), 2);
    ours_.Query(&ours, box);
    theirs_.Query(&theirs, box);
    EXPECT_EQ(ours.Sorted(), theirs.Sorted());
    query_count_ += ours.numbers.size();
    ours.numbers.clear();
    theirs.numbers.clear();
    b2RayCastInput ray;
    ray.p1.Set(Random(-20, 20), Random(-20, 20));
    ray.p2.Set(Random(-20, 20), Random(-20, 20));
    ray.maxFraction = Random(0.2F, 1.5F);
    ours_.RayCast(&ours, ray);
    theirs_.RayCast(&theirs, ray);
    EXPECT_EQ(ours.Sorted(), theirs.Sorted());
    query_count_ += ours.numbers.size();
  }

  b2BroadPhase theirs_;
  std::vector<Proxy> live_;
  std::minstd_rand random_{static_cast<uint32_t>(FromEnvironment("TEST_SEED", 1))};
  size_t pair_count_ = 0;
  size_t query_count_ = 0;
};

INSTANTIATE_TEST_SUITE_P(Each, SameCallsTest, ::testing::ValuesIn(BroadPhaseNames()),
                         [](const auto& arm) { return std::string(arm.param); });

// A third of the proxies never moves, so that proxies at rest are tested too. In half of the steps
// few proxies move, so that ours makes queries.
TEST_P(SameCallsTest, GiveTheSameResultsAsTheBroadPhaseOfBox2D) {
  for (int i = 0; i < 200; ++i) Create();
  for (int step = 0; step < 200; ++step) {
    for (size_t at = 0; at < live_.size(); ++at) {
      if (at % 3 != 0 && random_() % (step % 2 == 0 ? 4 : 40) == 0) Move(live_[at]);
    }
    if (step % 2 == 0) Create();
    if (step % 5 == 0) Destroy(random_() % live_.size());
    if (step % 3 == 0) {
      const Proxy& touched = live_[random_() % live_.size()];
      ours_.TouchProxy(touched.ours);
      theirs_.TouchProxy(touched.theirs);
    }
    if (step % 70 == 69) {
      ours_.ShiftOrigin({1, -2});
      theirs_.ShiftOrigin({1, -2});
      for (Proxy& proxy : live_) proxy.place -= b2Vec2(1, -2);
    }
    ExpectSamePairs();
    ExpectSameBoxes();
    ExpectSameQueries();
    ASSERT_FALSE(HasFailure()) << "step " << step;
  }
  EXPECT_GT(pair_count_, 2000U);
  EXPECT_GT(query_count_, 400U);
}

TEST_P(Box2dBroadPhaseTest, ReportsPairsByAscendingIds) {
  for (int i = 0; i < 200; ++i) Add(static_cast<float>(i * 77 % 200) * 0.3F, 0);
  const auto pairs = NewPairs();
  EXPECT_GT(pairs.size(), 200U);
  EXPECT_TRUE(std::is_sorted(pairs.begin(), pairs.end()));
}

TEST_P(Box2dBroadPhaseTest, ReportsAPairOnceAfterAMove) {
  Add(0, 0);
  const int32 b = Add(0.5F, 0);
  Add(1, 0);
  EXPECT_THAT(NewPairs(), ElementsAre(std::pair(0, 1), std::pair(0, 2), std::pair(1, 2)));
  EXPECT_THAT(NewPairs(), IsEmpty());
  ours_.MoveProxy(b, BoxAt(0.55F, 0), {0, 0});  // within the fat box
  EXPECT_THAT(NewPairs(), IsEmpty());
  ours_.TouchProxy(b);
  EXPECT_THAT(NewPairs(), ElementsAre(std::pair(0, 1), std::pair(1, 2)));
  EXPECT_THAT(NewPairs(), IsEmpty());
}

TEST_P(Box2dBroadPhaseTest, AQueryEndsWhenTheCallbackReturnsFalse) {
  for (int i = 0; i < 5; ++i) Add(0, 0);
  Found<Box2dBroadPhase> found{&ours_, /*limit=*/2};
  ours_.Query(&found, BoxAt(0, 0));
  EXPECT_THAT(found.numbers, ElementsAre(0, 1));
}

TEST_P(Box2dBroadPhaseTest, TheResultOfTheCallbackShortensOrEndsARay) {
  for (const float x : {6.0F, 2.0F, 4.0F}) Add(x, 0);
  b2RayCastInput ray;
  ray.p1.Set(0, 0);
  ray.p2.Set(10, 0);
  ray.maxFraction = 1;
  const auto cast = [&](float result) {
    Found<Box2dBroadPhase> found{.broad_phase = &ours_, .ray_result = result};
    ours_.RayCast(&found, ray);
    return found.numbers;
  };
  EXPECT_THAT(cast(-1), ElementsAre(1, 2, 0));
  EXPECT_THAT(cast(1), ElementsAre(1, 2, 0));
  EXPECT_THAT(cast(0.45F), ElementsAre(1, 2));
  EXPECT_THAT(cast(0), ElementsAre(1));
}

TEST_P(Box2dBroadPhaseTest, InvalidBoxesRaysAndOffsetsFindNothing) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const int32 a = Add(0, 0);
  Add(kNan, 0);
  EXPECT_THAT(NewPairs(), IsEmpty());
  Found<Box2dBroadPhase> found{&ours_};
  ours_.Query(&found, BoxAt(kNan, 0));
  b2RayCastInput ray;
  ray.p1.Set(kNan, 0);
  ray.p2.Set(1, 0);
  ray.maxFraction = 1;
  ours_.RayCast(&found, ray);
  EXPECT_THAT(found.numbers, IsEmpty());
  const b2AABB before = ours_.GetFatAABB(a);
  ours_.ShiftOrigin({kNan, 0});
  EXPECT_TRUE(AreEqual(ours_.GetFatAABB(a), before));
}

// With 20 changed proxies of 100 an update searches, with 2 it makes queries.
TEST_P(Box2dBroadPhaseTest, ABurstLeavesNoWorkAndNoMemoryIfUpdatesSearch) {
  ExpectNothingLeftOfABurst(/*changed_count=*/20, /*awake_count=*/20);
}

TEST_P(Box2dBroadPhaseTest, ABurstLeavesNoWorkAndNoMemoryIfUpdatesQuery) {
  ExpectNothingLeftOfABurst(/*changed_count=*/2, /*awake_count=*/100);
}

// FrameSample::pair_count counts the pairs that the arm has found.
TEST_P(Box2dBroadPhaseTest, ProxiesAtRestAreNotSearchedUntilTheyMove) {
  Add(0, 0);
  Add(0.5F, 0);
  const int32 moving = Add(50, 0);  // so that each update searches
  for (const float y : {0.0F, 5.0F}) {
    ours_.MoveProxy(0, BoxAt(0, y), {0, 0});
    ours_.MoveProxy(1, BoxAt(0.5F, y), {0, 0});
    for (int update = 0; update <= 30; ++update) {
      ours_.TouchProxy(moving);
      NewPairs();
      EXPECT_EQ(search_->last_sample().pair_count, 1U) << update;
    }
    ours_.TouchProxy(moving);
    NewPairs();
    EXPECT_EQ(search_->last_sample().pair_count, 0U);
  }
}

TEST_P(Box2dBroadPhaseTest, FewChangedProxiesAreQueriedWithoutASearch) {
  for (int i = 0; i < 24; ++i) Add(static_cast<float>(i), 0);
  NewPairs();
  EXPECT_EQ(search_->last_sample().object_count, 24U);
  for (const int32 id : {5, 4, 4}) ours_.TouchProxy(id);
  EXPECT_THAT(NewPairs(), ElementsAre(std::pair(3, 4), std::pair(4, 5), std::pair(5, 6)));
  EXPECT_EQ(search_->last_sample().object_count, 0U);
  for (const int32 id : {4, 5, 9, 10}) ours_.TouchProxy(id);
  EXPECT_EQ(NewPairs().size(), 6U);
  EXPECT_EQ(search_->last_sample().object_count, 24U);
}

TEST_P(Box2dBroadPhaseTest, AProxyInAReusedPlaceIsReportedOnce) {
  for (int i = 0; i < 20; ++i) Add(static_cast<float>(i), 0);
  NewPairs();
  ours_.TouchProxy(5);
  ours_.DestroyProxy(5);
  EXPECT_EQ(Add(7.5F, 0), 5);
  EXPECT_THAT(NewPairs(), ElementsAre(std::pair(20, 7), std::pair(20, 8)));
}

TEST_P(Box2dBroadPhaseTest, ReportsThePairsOfASearchWithTooManyInTheNextUpdate) {
  Add(0, 0);
  Add(0.5F, 0);
  EXPECT_THAT(NewPairs(), ElementsAre(std::pair(0, 1)));
  std::vector<int32> crowd;
  for (size_t i = 0; i < kTooManyBoxes; ++i) crowd.push_back(Add(100, 0));
  const int number = static_cast<int>(next_);
  Add(0.2F, 0);
  EXPECT_THAT(NewPairs(), IsEmpty());
  EXPECT_TRUE(search_->pairs_exceeded());
  for (const int32 id : crowd) ours_.DestroyProxy(id);
  EXPECT_THAT(NewPairs(), ElementsAre(std::pair(0, number), std::pair(1, number)));
  EXPECT_FALSE(search_->pairs_exceeded());
}

TEST_P(Box2dBroadPhaseTest, CountsThePairsOfProxiesAtRest) {
  for (size_t i = 0; i < kTooManyBoxes - 20; ++i) Add(100, 0);
  std::vector<int32> apart;
  for (int i = 0; i < 40; ++i) apart.push_back(Add(static_cast<float>(i) * 3, 50));
  for (int update = 0; update < 32; ++update) {
    NewPairs();
    ASSERT_FALSE(search_->pairs_exceeded());
    for (const int32 id : apart) ours_.TouchProxy(id);
  }
  ASSERT_EQ(ours_.awake_count(), 40U);
  std::vector<int32> crowd;
  for (int i = 0; i < 40; ++i) crowd.push_back(Add(100, 0));
  EXPECT_THAT(NewPairs(), IsEmpty());
  EXPECT_TRUE(search_->pairs_exceeded());
  while (crowd.size() > 1) {
    ours_.DestroyProxy(crowd.back());
    crowd.pop_back();
  }
  EXPECT_THAT(NewPairs(), SizeIs(kTooManyBoxes - 20));
  EXPECT_FALSE(search_->pairs_exceeded());
}

// An update with few changed proxies makes queries instead of a search.
TEST_P(Box2dBroadPhaseTest, CountsThePairsThatQueriesFind) {
  const auto create = [&](float x, float half) {
    return ours_.CreateProxy(BoxAt(x, 0, half), numbers_.data());
  };
  for (int i = 0; i < 2000; ++i) create(static_cast<float>(i) * 3, 0.5F);
  EXPECT_THAT(NewPairs(), IsEmpty());
  const int32 first = create(0, 1e4F);
  create(0, 1e4F);
  for (int i = 0; i < 4; ++i) create(0, 1e4F);
  EXPECT_THAT(NewPairs(), IsEmpty());
  EXPECT_TRUE(search_->pairs_exceeded());
  ours_.DestroyProxy(first);
  ours_.DestroyProxy(first + 1);
  EXPECT_THAT(NewPairs(), SizeIs(4 * 2000 + 6));
  EXPECT_FALSE(search_->pairs_exceeded());
}

TEST_P(Box2dBroadPhaseTest, AnUpdateAllocatesNothingInSteadyState) {
  std::vector<int32> ids(200);
  for (size_t i = 0; i < ids.size(); ++i) ids[i] = Add(static_cast<float>(i) * 0.7F, 0);
  struct Counter {
    void AddPair(void* /*a*/, void* /*b*/) { ++count; }
    int count = 0;
  } counter;
  uint64_t before = 0;
  for (int step = 0; step < 500; ++step) {
    if (step == 300) before = ThreadAllocationCount();
    for (size_t i = 0; i < ids.size(); i += 3) {
      const float y = static_cast<float>(step % 4) * 0.4F;
      ours_.MoveProxy(ids[i], BoxAt(static_cast<float>(i) * 0.7F, y), {0, 0.4F});
    }
    search_->BeginFrame();
    ours_.UpdatePairs(&counter);
    search_->EndFrame({});
  }
  EXPECT_EQ(ThreadAllocationCount(), before);
  EXPECT_GT(counter.count, 1000);
}

}  // namespace
}  // namespace sweepstake::test_support
