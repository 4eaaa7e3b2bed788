// What an AdaptiveBroadPhase frees when it is told to, and beyond its budget.
#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "engine_client/scene/suite_scene.h"
#include "sweepstake/adaptive_broad_phase.h"
#include "tests/support/pair_oracle.h"

namespace sweepstake {
namespace {

using test_support::PairDifference;
using test_support::ScalarPairs;

// Two arms without a lane; every search must find the pairs of brute force.
class TrimTest : public ::testing::Test {
 protected:
  void Make(uint64_t memory_budget_bytes) {
    adaptive_ = std::move(*AdaptiveBroadPhase::Create({.arms = {"KDTree", "Tracy"},
                                                       .mode = Mode::kManual,
                                                       .shadow = {.enabled = ShadowMode::kOff},
                                                       .memory_budget_bytes = memory_budget_bytes},
                                                      nullptr));
  }
  void Frame() {
    adaptive_->BeginFrame();
    const auto pairs = adaptive_->FindPairs(scene_->aabbs());
    EXPECT_EQ(PairDifference(pairs, ScalarPairs(scene_->aabbs())), "");
    adaptive_->EndFrame({.frame_time_ns = 1'000'000});
    scene_->Step();
  }
  void FrameWith(std::string_view arm) {
    EXPECT_TRUE(adaptive_->SelectArm(arm).ok());
    Frame();
  }
  uint64_t active_bytes() const { return adaptive_->last_sample().native_bytes; }

  std::unique_ptr<Scene> scene_ = MakeSuiteBrownian(2000);
  std::unique_ptr<AdaptiveBroadPhase> adaptive_;
};

TEST_F(TrimTest, FreesInactiveArmsAndPairsAndNothingElse) {
  Make(0);
  Frame();
  const uint64_t first_bytes = active_bytes();
  FrameWith("Tracy");
  EXPECT_GT(adaptive_->memory_bytes(), first_bytes + active_bytes());
  adaptive_->Trim();
  EXPECT_EQ(adaptive_->memory_bytes(), active_bytes());
  Frame();
  EXPECT_EQ(adaptive_->last_sample().flags & kFrameRebuild, 0U) << "the active arm's is kept";
}

TEST_F(TrimTest, AnArmThatWasFreedIsBuiltAtTheNextSwitchToIt) {
  Make(0);
  Frame();
  FrameWith("Tracy");
  adaptive_->Trim();
  FrameWith("KDTree");
  EXPECT_NE(adaptive_->last_sample().flags & kFrameRebuild, 0U);
  Frame();
}

TEST_F(TrimTest, ASwitchBeyondTheBudgetFreesTheArmThatItLeaves) {
  for (const uint64_t budget_bytes : {uint64_t{1}, uint64_t{1} << 30}) {
    Make(budget_bytes);
    Frame();
    const uint64_t left_bytes = active_bytes();
    FrameWith("Tracy");
    const uint64_t kept_bytes = adaptive_->memory_bytes() - active_bytes();
    EXPECT_EQ(kept_bytes >= left_bytes, budget_bytes > 1);
    FrameWith("KDTree");
    Frame();
  }
}

}  // namespace
}  // namespace sweepstake
