#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "sweepstake/scene.h"
#include "tests/engine_client/scene/scene_fixtures.h"

namespace sweepstake {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

struct FloatOption {
  const char* name;
  float SceneOptions::*field;
};

constexpr FloatOption kFloatOptions[] = {
    {"world_half_extent", &SceneOptions::world_half_extent},
    {"fixed_step_s", &SceneOptions::fixed_step_s},
    {"half_extent_min", &SceneOptions::half_extent_min},
    {"half_extent_max", &SceneOptions::half_extent_max},
    {"speed", &SceneOptions::speed},
    {"gravity", &SceneOptions::gravity},
    {"direction_interval_s", &SceneOptions::direction_interval_s},
};

TEST(MakeScene, KnowsTheEightNamesOfTheCommandLine) {
  EXPECT_THAT(SceneNames(), ElementsAre("brownian", "rotating-gravity", "hurricane", "free-fall",
                                        "random-gravity", "suite-b", "suite-g", "suite-h"));
  for (const std::string_view name : SceneNames()) {
    EXPECT_EQ(MustMakeScene(name, WithCount(3))->name(), name);
  }
}

TEST(MakeScene, AnUnknownNameIsAnErrorThatListsAllNames) {
  const Status status = MakeScene("tornado\n", {}).status();
  EXPECT_EQ(status.code(), StatusCode::kNotFound);
  EXPECT_THAT(status.message(), HasSubstr("'tornado?'"));
  EXPECT_THAT(status.message(), HasSubstr(".aabbs"));
  for (const std::string_view name : SceneNames()) {
    EXPECT_THAT(status.message(), HasSubstr(std::string(name)));
  }
}

TEST(MakeScene, AnOptionThatIsNotFiniteOrNegativeIsNamedInTheError) {
  for (const FloatOption& option : kFloatOptions) {
    for (const float value : {kNan, kInfinity, -kInfinity, -1.0F}) {
      SceneOptions options;
      options.*option.field = value;
      const Status status = MakeScene("brownian", options).status();
      EXPECT_EQ(status.code(), StatusCode::kInvalidArgument) << option.name << " = " << value;
      EXPECT_THAT(status.message(), HasSubstr(std::string(option.name) + " must be from "));
    }
  }
}

TEST(MakeScene, SpeedAndGravityMayBeZeroButTimesAndSizesMayNot) {
  for (const FloatOption& option : kFloatOptions) {
    SceneOptions options;
    options.*option.field = 0;
    const std::string_view name = option.name;
    const bool valid = name == "speed" || name == "gravity";
    EXPECT_EQ(MakeScene("rotating-gravity", options).ok(), valid) << name;
  }
}

TEST(MakeScene, SizesMustBeOrderedAndFitTheWorld) {
  SceneOptions options;
  options.half_extent_min = 2;
  options.half_extent_max = 1;
  EXPECT_THAT(MakeScene("hurricane", options).status().message(),
              HasSubstr("half_extent_max must be from 2 to 50, not 1"));
  options.half_extent_max = 51;
  EXPECT_FALSE(MakeScene("hurricane", options).ok());
}

TEST(MakeScene, MoreObjectsThanTheBoundAreRefused) {
  for (const std::string_view name : SceneNames()) {
    const Status status = MakeScene(name, WithCount(16'777'217)).status();
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
    EXPECT_THAT(status.message(), HasSubstr("object_count must be from 0 to 16777216"));
  }
}

TEST(MakeScene, NoObjectsIsAValidScene) {
  for (const std::string_view name : SceneNames()) {
    const std::unique_ptr<Scene> scene = MustMakeScene(name, WithCount(0));
    scene->Step();
    EXPECT_TRUE(scene->aabbs().empty());
    EXPECT_EQ(scene->frame_index(), 1U);
  }
}

TEST(MakeScene, ExtremeOptionsWithinTheRangesKeepEveryBoxFinite) {
  SceneOptions options = WithCount(20);
  options.fixed_step_s = 1;
  options.speed = 1e6F;
  options.gravity = 1e6F;
  options.half_extent_max = options.world_half_extent;
  for (const std::string_view name : SceneNames()) {
    const std::unique_ptr<Scene> scene = MustMakeScene(name, options);
    StepTimes(*scene, 500);
    for (const Aabb& box : scene->aabbs()) EXPECT_TRUE(TakesPart(box)) << name;
  }
}

}  // namespace
}  // namespace sweepstake
