// Tests how AdaptiveBroadPhase::Create applies its options, and which it refuses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "sweepstake/adaptive_broad_phase.h"

namespace sweepstake {
namespace {

using ::testing::HasSubstr;

AdaptiveOptions OptionsOf(std::vector<std::string> arms) {
  AdaptiveOptions options;
  options.arms = std::move(arms);
  return options;
}

TEST(AdaptiveCreateTest, AnUnknownArmListsTheBackends) {
  const auto result = AdaptiveBroadPhase::Create(OptionsOf({"Octopus"}), nullptr);
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.status().code(), StatusCode::kNotFound);
  EXPECT_THAT(result.status().message(), HasSubstr("BruteForce"));
}

TEST(AdaptiveCreateTest, NamesTheSameMistakeInTheSameWords) {
  const auto error = [](const AdaptiveOptions& options) {
    return AdaptiveBroadPhase::Create(options, nullptr).status().message();
  };
  EXPECT_THAT(error({.initial_arm = "sap"}), HasSubstr("unknown arm 'sap', must be one of SAP"));
  EXPECT_EQ(error(OptionsOf({"Grid", "sap"})), error({.initial_arm = "sap"}));
}

TEST(AdaptiveCreateTest, RefusesRepeatedArmsBadLimitsAndAnUnknownInitialArm) {
  const auto code = [](const AdaptiveOptions& options) {
    return AdaptiveBroadPhase::Create(options, nullptr).status().code();
  };
  EXPECT_EQ(code(OptionsOf({"BruteForce", "BruteForce"})), StatusCode::kInvalidArgument);
  EXPECT_EQ(code(OptionsOf(std::vector<std::string>(33, "BruteForce"))),
            StatusCode::kInvalidArgument);
  AdaptiveOptions options = OptionsOf({"BruteForce"});
  options.bail_out_ns = 0;
  EXPECT_EQ(code(options), StatusCode::kInvalidArgument);
  options = OptionsOf({"BruteForce"});
  options.mode = static_cast<Mode>(0);
  EXPECT_EQ(code(options), StatusCode::kInvalidArgument);
  options = OptionsOf({"BruteForce"});
  options.initial_arm = "Grid";
  EXPECT_EQ(code(options), StatusCode::kNotFound);
}

TEST(AdaptiveCreateTest, StartsWithKdTreeOrTheFirstNamedArm) {
  const auto initial = [](const AdaptiveOptions& options) {
    const auto adaptive = AdaptiveBroadPhase::Create(options, nullptr);
    if (!adaptive.ok()) return std::string();
    EXPECT_EQ((*adaptive)->initial_arm(), (*adaptive)->active_arm());
    return (*adaptive)->arms()[(*adaptive)->active_arm()];
  };
  EXPECT_EQ(initial({}), "KDTree");
  EXPECT_EQ(initial({.initial_arm = "Grid"}), "Grid");
  EXPECT_EQ(initial(OptionsOf({"SAP", "KDTree"})), "SAP");
}

TEST(AdaptiveCreateTest, WorksWithoutASinkOnTheRealClock) {
  auto adaptive = AdaptiveBroadPhase::Create(OptionsOf({"BruteForce"}), nullptr);
  ASSERT_TRUE(adaptive.ok());
  const std::vector<Aabb> boxes(3, Aabb{{0, 0, 0}, {1, 1, 1}});
  (*adaptive)->BeginFrame();
  EXPECT_EQ((*adaptive)->FindPairs(boxes).size(), 3U);
  (*adaptive)->EndFrame({.frame_time_ns = 1});
}

}  // namespace
}  // namespace sweepstake
