// A search with more pairs than AdaptiveOptions::max_pairs returns none, and is not evidence.
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "engine_client/scene/suite_scene.h"
#include "sweepstake/adaptive_broad_phase.h"
#include "tests/engine_client/adaptive/driven_lane.h"
#include "tests/support/pair_oracle.h"
#include "tests/support/recording_sink.h"

namespace sweepstake {
namespace {

using test_support::PairDifference;
using test_support::RecordingSink;
using test_support::ScalarPairs;

class AdaptiveMaxPairsTest : public ::testing::Test {
 protected:
  void Make(std::string_view arm) {
    adaptive_ = std::move(*AdaptiveBroadPhase::Create({.arms = {std::string(arm)},
                                                       .mode = Mode::kManual,
                                                       .shadow = {.enabled = ShadowMode::kOff},
                                                       .sorted_pairs = true,
                                                       .max_pairs = 10'000},
                                                      &sink_));
  }
  void ExpectAllPairs() {
    const auto found = adaptive_->FindPairs(scene_->aabbs());
    EXPECT_FALSE(adaptive_->pairs_exceeded());
    EXPECT_EQ(PairDifference(found, ScalarPairs(scene_->aabbs())), "");
    scene_->Step();
  }
  void ExpectTooMany() {
    EXPECT_TRUE(adaptive_->FindPairs(dense_).empty());
    EXPECT_TRUE(adaptive_->pairs_exceeded());
  }
  uint32_t EndFrame() {
    adaptive_->EndFrame({.frame_time_ns = 1'000'000});
    return sink_.frames.back().flags;
  }

  const std::vector<Aabb> dense_ = std::vector<Aabb>(2000, Aabb{{0, 0, 0}, {1, 1, 1}});
  std::unique_ptr<Scene> scene_ = MakeSuiteBrownian(500);
  RecordingSink sink_;
  std::unique_ptr<AdaptiveBroadPhase> adaptive_;
};

TEST_F(AdaptiveMaxPairsTest, TheNextFrameRebuildsAndFindsAllPairsWithEveryArm) {
  for (const std::string_view arm : BroadPhaseNames()) {
    Make(arm);
    adaptive_->BeginFrame();
    ExpectAllPairs();
    EXPECT_EQ(EndFrame(), uint32_t{kFrameRebuild});
    for (const uint32_t rebuild : {0U, uint32_t{kFrameRebuild}}) {
      adaptive_->BeginFrame();
      ExpectTooMany();
      EXPECT_EQ(EndFrame(), uint32_t{kFramePairsExceeded} | rebuild) << arm;
      EXPECT_EQ(sink_.frames.back().pair_count, 0U);
    }
    adaptive_->BeginFrame();
    ExpectAllPairs();
    EXPECT_EQ(EndFrame(), uint32_t{kFrameRebuild}) << arm;
    adaptive_->BeginFrame();
    ExpectAllPairs();
    EXPECT_EQ(EndFrame(), 0U) << arm;
  }
}

TEST_F(AdaptiveMaxPairsTest, TheNextSubstepRebuildsAndTheFrameKeepsItsFlag) {
  Make("KDTree");
  adaptive_->BeginFrame();
  ExpectTooMany();
  ExpectAllPairs();
  EXPECT_EQ(EndFrame(), uint32_t{kFrameRebuild | kFramePairsExceeded});
}

// The arms of this lane are real backends with max_pairs; the boxes of a frame are all in one
// place.
class LaneMaxPairsTest : public test_support::DrivenLane {
 protected:
  ArmBackend MakeBackend(uint32_t arm) override {
    return {nullptr, std::move(*MakeBroadPhase(BroadPhaseNames()[arm], {.max_pairs = 45}))};
  }
};

TEST_F(LaneMaxPairsTest, TheLaneReportsNoVisitAndPreparesNoSwitchAboveTheMaximum) {
  object_count_ = 11;  // 55 pairs
  FirstSweep();
  EXPECT_GT(lane_->stats().visit_count, 0U);
  EXPECT_TRUE(sink_.shadows.empty());
  FramesUntilReady(2);
  EXPECT_EQ(lane_->Ask(2), ShadowLane::Preparation::kNever);
}

TEST_F(LaneMaxPairsTest, TheLaneMeasuresAndPreparesAtTheMaximum) {
  object_count_ = 10;  // 45 pairs
  FirstSweep();
  EXPECT_FALSE(sink_.shadows.empty());
  FramesUntilReady(2);
  EXPECT_EQ(lane_->Ask(2), ShadowLane::Preparation::kReady);
}

}  // namespace
}  // namespace sweepstake
