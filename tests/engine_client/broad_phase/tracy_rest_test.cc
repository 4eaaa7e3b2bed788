// Tests Tracy in scenes with little motion: margins that hold, and boxes that leave them.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "engine_client/broad_phase/grid/grid_plan.h"
#include "engine_client/broad_phase/tracy/tracy_rest.h"
#include "engine_client/scene/box_scenes.h"
#include "engine_client/scene/random.h"
#include "tests/engine_client/broad_phase/backend_under_test.h"

namespace sweepstake {
namespace {

using test_support::FindPairsError;
using test_support::MakeOrThrow;

constexpr size_t kCount = 1000;

class RestingTracy : public testing::Test {
 protected:
  RestingTracy() : boxes_(scene_.boxes().begin(), scene_.boxes().end()) {
    backend_->Build(boxes_);
    for (int frame = 0; frame < 5; ++frame) StepAndCheck("while the boxes come to rest");
    EXPECT_LT(ChecksPerBox(), 5U) << "a resting scene must need few checks";
  }

  // Moves all boxes except the first ten, which the test moves itself.
  void Step() {
    scene_.Step();
    std::copy(scene_.boxes().begin() + 10, scene_.boxes().end(), boxes_.begin() + 10);
  }
  void Check(const std::string& when) {
    backend_->Update(boxes_);
    ASSERT_EQ(FindPairsError(*backend_, boxes_, pairs_), "") << when;
  }
  void StepAndCheck(const std::string& when) {
    Step();
    Check(when);
  }
  uint64_t ChecksPerBox() const { return backend_->aabb_check_count() / boxes_.size(); }

  BoxScene scene_{"nearly-resting", kCount, 8};
  std::vector<Aabb> boxes_;
  std::unique_ptr<BroadPhase> backend_ = MakeOrThrow("Tracy");
  PairBuffer pairs_;
};

TEST_F(RestingTracy, MakesLittleMoreChecksThanThereArePairs) {
  uint64_t checks = 0;
  for (int frame = 0; frame < 50; ++frame) {
    StepAndCheck("at rest");
    checks += backend_->aabb_check_count();
  }
  EXPECT_LT(checks, 50U * 5 * kCount);
}

TEST_F(RestingTracy, FollowsAFewFastBoxesAndStaysAtRest) {
  for (int frame = 0; frame < 30; ++frame) {
    for (size_t i = 0; i < 10; ++i) {
      const float at = 0.3F * static_cast<float>(frame) + static_cast<float>(i) * 0.4F;
      boxes_[i] = {{at, at / 2, 3}, {at + 1, at / 2 + 1, 4}};
    }
    StepAndCheck("in frame " + std::to_string(frame));
  }
  EXPECT_LT(ChecksPerBox(), 40U);
}

TEST_F(RestingTracy, FollowsABoxThatLeavesAndReturns) {
  const Aabb home = boxes_[4];
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const Aabb& away :
       {Aabb{{nan, 0, 0}, {1, 1, 1}}, Aabb{{1, 1, 1}, {0, 0, 0}},
        Aabb{{-50, -50, -50}, {50, 50, 50}}, Aabb{{1e30F, 1e30F, 1e30F}, {2e30F, 2e30F, 2e30F}}}) {
    boxes_[4] = away;
    StepAndCheck("away");
    StepAndCheck("still away");
    boxes_[4] = home;
    StepAndCheck("home");
  }
}

TEST_F(RestingTracy, FollowsAChangingObjectCount) {
  const std::vector<Aabb> all = boxes_;
  for (const size_t count : {kCount - 1, kCount, kCount / 2, size_t{0}, kCount, kCount}) {
    boxes_.assign(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count));
    Check("with " + std::to_string(count));
    Check("with the same count again");
    Check("with the same count a third time");
  }
}

TEST_F(RestingTracy, FollowsMotionOfAllBoxesAndRestsAgain) {
  for (int frame = 0; frame < 8; ++frame) {
    for (Aabb& box : boxes_) {
      box.min[0] += 0.2F;
      box.max[0] += 0.2F;
    }
    Check("in motion");
  }
  for (int frame = 0; frame < 40; ++frame) Check("at rest again");
  EXPECT_LT(ChecksPerBox(), 5U);
}

// Brownian boxes with margins.
class BoxesWithMargins {
 public:
  BoxesWithMargins(size_t count, Executor* executor)
      : executor_(executor), scene_("brownian", count, 3) {
    GridPlan plan;
    plan.Reset();
    plan.MakeGrids(nullptr, scene_.boxes());
    lists_.Reset(RowGrids(plan));
    lists_.Update(nullptr, boxes_);
  }
  // Sets margins, and returns whether the boxes can be kept with them.
  bool Start(float margin) {
    checks_ = 0;
    lists_.SetMargin(margin);
    const bool kept = rest_.Start(executor_, boxes_, margin, lists_, checks_, nullptr);
    if (!kept) lists_.Update(nullptr, boxes_);
    return kept;
  }
  std::vector<OverlapPair> Pairs() const {
    PairBuffer pairs;
    rest_.Append(pairs);
    return {pairs.pairs().begin(), pairs.pairs().end()};
  }
  uint64_t checks() const { return checks_; }
  size_t native_bytes() const { return rest_.native_bytes(); }

 private:
  Executor* executor_;
  BoxScene scene_;
  GridBoxes boxes_{scene_.boxes(), scene_.boxes()};
  TracyLists lists_;
  TracyRest rest_;
  uint64_t checks_ = 0;
};

TEST(TracyRest, DoesNotKeepMarginsThatAddTooManyPairs) {
  BoxesWithMargins boxes(4000, nullptr);
  EXPECT_TRUE(boxes.Start(0.05F));
  EXPECT_FALSE(boxes.Start(0.55F)) << "about 24 pairs per box";
  EXPECT_FALSE(boxes.Start(100));
  EXPECT_LE(boxes.native_bytes(), 20'000'000U) << "the 8 million pairs of all boxes have 64 MB";
}

// A search in parts needs more memory than one on a single thread, and a later search needs no new
// memory.
TEST(TracyRest, KeepsTheSamePairsWithAnyNumberOfThreadsAndAfterOtherSearches) {
  constexpr size_t kMany = 24'000;
  const auto pool = MakeThreadPool(2);
  BoxesWithMargins alone(kMany, nullptr);
  BoxesWithMargins together(kMany, pool.get());
  // The margins add from 8 to 24 pairs per box.
  size_t kept_count = 0;
  for (const float margin : {0.20F, 0.25F, 0.30F, 0.35F, 0.38F, 0.40F, 0.42F, 0.44F, 0.46F, 0.50F,
                             0.55F, 0.46F, 0.42F, 0.38F, 0.30F}) {
    const bool kept = alone.Start(margin);
    ASSERT_EQ(together.Start(margin), kept) << margin;
    ASSERT_EQ(BoxesWithMargins(kMany, pool.get()).Start(margin), kept) << margin;
    if (!kept) continue;
    ++kept_count;
    ASSERT_EQ(together.checks(), alone.checks()) << margin;
    ASSERT_EQ(together.Pairs(), alone.Pairs()) << margin;
  }
  EXPECT_GT(kept_count, 5U);
  EXPECT_LT(kept_count, 15U);
}

// Tracy keeps pairs only if testing them again is cheaper than a new search, which is not the case
// for half a million pairs.
TEST(Tracy, KeepsNoPairsIfThereAreTooMany) {
  BoxScene scene("all-coincident", kCount, 5);
  const auto backend = MakeOrThrow("Tracy");
  PairBuffer pairs;
  backend->Build(scene.boxes());
  for (int frame = 0; frame < 6; ++frame) {
    EXPECT_EQ(FindPairsError(*backend, scene.boxes(), pairs), "");
    backend->Update(scene.boxes());
  }
  EXPECT_LE(backend->native_bytes(), kCount * 500);
}

TEST(Tracy, FindsTheSamePairsAtRestWithAnyNumberOfThreads) {
  const auto pool = MakeThreadPool(3);
  const auto together = std::move(*MakeBroadPhase("Tracy", {pool.get()}));
  const auto alone = MakeOrThrow("Tracy");
  BoxScene scene("nearly-resting", 20'000, 5);
  alone->Build(scene.boxes());
  together->Build(scene.boxes());
  PairBuffer pairs;
  PairBuffer pairs_together;
  for (int frame = 0; frame < 6; ++frame, scene.Step()) {
    pairs.Clear();
    pairs_together.Clear();
    alone->Update(scene.boxes());
    together->Update(scene.boxes());
    alone->FindPairs(pairs);
    together->FindPairs(pairs_together);
    ASSERT_TRUE(std::ranges::equal(pairs.pairs(), pairs_together.pairs())) << frame;
  }
}

// Returns about 24,000 boxes with this side in cubes of side 1, 20 units apart.
std::vector<Aabb> BoxesInClusters(size_t boxes_per_cluster, float side) {
  SequentialRandom random(5);
  std::vector<Aabb> boxes;
  for (size_t cluster = 0; cluster < 24'000 / boxes_per_cluster; ++cluster) {
    const size_t at[3] = {cluster % 9, cluster / 9 % 9, cluster / 81};
    for (size_t k = 0; k < boxes_per_cluster; ++k) {
      Aabb& box = boxes.emplace_back();
      for (int axis = 0; axis < 3; ++axis) {
        box.min[axis] = 20 * static_cast<float>(at[axis]) + random.Between(0, 1);
        box.max[axis] = box.min[axis] + side;
      }
    }
  }
  return boxes;
}

// Margins add pairs to these scenes until there are about as many as may be kept.
TEST(Tracy, FindsTheSamePairsInClustersWithAnyNumberOfThreads) {
  const auto pool = MakeThreadPool(2);
  for (const size_t boxes_per_cluster : {32, 48, 56}) {
    for (const float side : {0.35F, 0.40F, 0.44F, 0.45F}) {
      const std::vector<Aabb> boxes = BoxesInClusters(boxes_per_cluster, side);
      const auto together = std::move(*MakeBroadPhase("Tracy", {pool.get()}));
      const auto alone = MakeOrThrow("Tracy");
      alone->Build(boxes);
      together->Build(boxes);
      PairBuffer pairs;
      PairBuffer pairs_together;
      for (int frame = 0; frame < 6; ++frame) {
        pairs.Clear();
        pairs_together.Clear();
        alone->FindPairs(pairs);
        together->FindPairs(pairs_together);
        ASSERT_TRUE(std::ranges::equal(pairs.pairs(), pairs_together.pairs()))
            << boxes_per_cluster << " boxes of " << side << " in frame " << frame;
        ASSERT_EQ(alone->aabb_check_count(), together->aabb_check_count());
        alone->Update(boxes);
        together->Update(boxes);
      }
    }
  }
}

}  // namespace
}  // namespace sweepstake
