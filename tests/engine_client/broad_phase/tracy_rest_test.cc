// Tests Tracy in scenes with little motion: margins that hold, and boxes that leave them.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "engine_client/broad_phase/grid/grid_plan.h"
#include "engine_client/broad_phase/tracy/tracy_rest.h"
#include "engine_client/scene/box_scenes.h"
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

// Returns whether 4,000 brownian boxes can be kept with this margin.
bool CanKeep(float margin, size_t& bytes) {
  const BoxScene scene("brownian", 4000, 3);
  const GridBoxes boxes{scene.boxes(), scene.boxes()};
  GridPlan plan;
  plan.Reset();
  plan.MakeGrids(nullptr, scene.boxes());
  TracyLists lists;
  lists.Reset(RowGrids(plan));
  lists.Update(nullptr, boxes);
  lists.SetMargin(margin);
  TracyRest rest;
  uint64_t checks = 0;
  const bool kept = rest.Start(nullptr, boxes, margin, lists, checks, nullptr);
  bytes = rest.native_bytes();
  return kept;
}

TEST(TracyRest, DoesNotKeepMarginsThatAddTooManyPairs) {
  size_t bytes = 0;
  EXPECT_TRUE(CanKeep(0.05F, bytes));
  EXPECT_FALSE(CanKeep(0.55F, bytes)) << "about 24 pairs per box";
  EXPECT_FALSE(CanKeep(100, bytes));
  EXPECT_LE(bytes, 20'000'000U) << "the 8 million pairs of all boxes have 64 MB";
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

}  // namespace
}  // namespace sweepstake
