// Tests which memory AdaptiveBroadPhase frees with Trim and above its budget.
#include <gtest/gtest.h>

#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "engine_client/adaptive/adaptive_factory.h"
#include "engine_client/scene/suite_scene.h"
#include "sweepstake/adaptive_broad_phase.h"
#include "tests/support/pair_oracle.h"

namespace sweepstake {
namespace {

using test_support::PairDifference;
using test_support::ScalarPairs;

// Two arms, without a lane unless a test makes one. Every search must find the pairs of brute
// force.
class TrimTest : public ::testing::Test {
 protected:
  void Make(uint64_t memory_budget_bytes) {
    options_.memory_budget_bytes = memory_budget_bytes;
    adaptive_ = std::move(*AdaptiveBroadPhase::Create(options_, nullptr));
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

  // Creates a lane on its own thread, as on a machine with two cores.
  void MakeWithLane(uint64_t memory_budget_bytes) {
    const auto make = [this](uint32_t arm) {
      return ArmBackend{nullptr, std::move(*MakeBroadPhase(options_.arms[arm]))};
    };
    options_.memory_budget_bytes = memory_budget_bytes;
    options_.shadow.enabled = ShadowMode::kOn;
    std::vector<ArmBackend> backends;
    for (uint32_t arm = 0; arm < options_.arms.size(); ++arm) backends.push_back(make(arm));
    adaptive_ = std::move(*AdaptiveFactory::Make(options_, std::move(backends),
                                                 {make, []() noexcept { return size_t{2}; }},
                                                 nullptr, SteadyClock()));
  }
  ShadowStats lane() const { return adaptive_->shadow_stats(); }

  AdaptiveOptions options_{
      .arms = {"KDTree", "Tracy"}, .mode = Mode::kManual, .shadow = {.enabled = ShadowMode::kOff}};
  std::unique_ptr<Scene> scene_ = MakeSuiteBrownian(2000);
  std::unique_ptr<AdaptiveBroadPhase> adaptive_;
};

TEST_F(TrimTest, FreesOnlyInactiveArmsAndPairs) {
  Make(0);
  Frame();
  const uint64_t first_bytes = active_bytes();
  FrameWith("Tracy");
  EXPECT_GT(adaptive_->memory_bytes(), first_bytes + active_bytes());
  adaptive_->Trim();
  EXPECT_EQ(adaptive_->memory_bytes(), active_bytes());
  Frame();
  EXPECT_EQ(adaptive_->last_sample().flags & kFrameRebuild, 0U)
      << "the structure of the active arm is kept";
}

TEST_F(TrimTest, AFreedArmIsBuiltAtTheNextSwitchToIt) {
  Make(0);
  Frame();
  FrameWith("Tracy");
  adaptive_->Trim();
  FrameWith("KDTree");
  EXPECT_NE(adaptive_->last_sample().flags & kFrameRebuild, 0U);
  Frame();
}

TEST_F(TrimTest, ASwitchOverTheBudgetFreesTheFormerArm) {
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

TEST_F(TrimTest, AnArmThatGrowsOverTheBudgetFreesTheInactiveOne) {
  uint64_t inactive_bytes = 0;
  uint64_t bytes[2];
  for (const bool has_budget : {false, true}) {
    scene_ = MakeSuiteBrownian(2000);
    Make(0);
    Frame();
    inactive_bytes = active_bytes();
    FrameWith("Tracy");
    if (has_budget) {
      Make(adaptive_->memory_bytes() + 1000);
      scene_ = MakeSuiteBrownian(2000);
      Frame();
      FrameWith("Tracy");
    }
    Frame();
    EXPECT_GT(adaptive_->memory_bytes(), active_bytes() + inactive_bytes)
        << "all structures are kept";
    scene_ = MakeSuiteBrownian(3000);
    Frame();
    Frame();
    bytes[has_budget] = adaptive_->memory_bytes();
  }
  EXPECT_EQ(bytes[false] - bytes[true], inactive_bytes);
}

TEST_F(TrimTest, CountsAndFreesTheScratchMemoryOfSortedPairs) {
  options_.sorted_pairs = true;
  Make(0);
  const uint64_t empty_bytes = adaptive_->memory_bytes();
  Frame();
  const uint64_t pair_bytes = adaptive_->last_sample().pair_count * uint64_t{sizeof(OverlapPair)};
  EXPECT_GE(adaptive_->memory_bytes(), empty_bytes + active_bytes() + 2 * pair_bytes)
      << "the pairs, and equally much memory to sort them";
  adaptive_->Trim();
  EXPECT_EQ(adaptive_->memory_bytes(), empty_bytes + active_bytes());
  Frame();
}

TEST_F(TrimTest, TheLaneUsesAtMostHalfOfTheBudget) {
  // The lane's copies of four frames of 2,000 objects, with slack, take 222 KB. It may use half of
  // its memory for copies.
  constexpr uint64_t kTooLittle = 800'000;
  constexpr uint64_t kEnough = 8'000'000;
  for (const uint64_t budget_bytes : {kTooLittle, kEnough}) {
    MakeWithLane(budget_bytes);
    while (lane().state != ShadowState::kTooBig && lane().sweep_count == 0) {
      Frame();
      EXPECT_LE(lane().memory_bytes, budget_bytes / 2);
    }
    EXPECT_EQ(lane().state == ShadowState::kTooBig, budget_bytes == kTooLittle);
  }
}

TEST_F(TrimTest, FreesTheMemoryOfTheLane) {
  // A second sweep would reserve memory again, and wait for frames.
  options_.shadow.sweep_interval_min_ns = 3'600'000'000'000;  // an hour
  MakeWithLane(0);
  while (lane().sweep_count == 0) Frame();
  const uint64_t lane_bytes = lane().memory_bytes;
  EXPECT_GT(lane_bytes, 0U);
  EXPECT_GT(adaptive_->memory_bytes(), lane_bytes + active_bytes());
  adaptive_->Trim();
  while (lane().memory_bytes > 0) std::this_thread::yield();
  EXPECT_EQ(adaptive_->memory_bytes(), active_bytes());
}

TEST_F(TrimTest, AFreezeFreesTheMemoryOfTheLane) {
  MakeWithLane(0);
  while (lane().sweep_count == 0) Frame();
  const uint64_t lane_bytes = lane().memory_bytes;
  adaptive_->Freeze();
  while (lane().memory_bytes >= lane_bytes) std::this_thread::yield();
  EXPECT_EQ(lane().state, ShadowState::kPaused);
  Frame();
}

}  // namespace
}  // namespace sweepstake
