#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>

#include "engine_client/scene/box_scenes.h"
#include "sweepstake/scene.h"
#include "tests/engine_client/scene/scene_fixtures.h"

namespace sweepstake {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

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

TEST(SceneRegistry, ListsTheScenesOfEachGroup) {
  EXPECT_THAT(SceneNames(SceneGroup::kReference),
              ElementsAre("brownian", "rotating-gravity", "hurricane", "free-fall",
                          "random-gravity", "suite-b", "suite-g", "suite-h"));
  EXPECT_THAT(SceneNames(SceneGroup::kChanging),
              ElementsAre("rest-and-motion", "waves", "storms", "gather-and-scatter",
                          "day-and-night", "arrivals"));
  EXPECT_THAT(SceneNames(SceneGroup::kDegenerate),
              AllOf(SizeIs(26), Contains("broken-boxes"), Contains("mixture")));
}

TEST(SceneRegistry, EveryNameMakesASceneOfThatName) {
  ASSERT_THAT(SceneNames(), SizeIs(40));
  for (const SceneDescription& scene : SceneDescriptions()) {
    EXPECT_EQ(MustMakeScene(scene.name, WithCount(3))->name(), scene.name);
    EXPECT_THAT(SceneNames(scene.group), Contains(scene.name));
    EXPECT_FALSE(scene.summary.empty());
  }
}

TEST(MakeScene, TheSpawnSeedDeterminesChangingAndDegenerateScenes) {
  SceneOptions other = WithCount(50);
  other.spawn_seed = 2;
  for (const std::string_view name : {"waves", "mixture"}) {
    const uint64_t hash = HashOfFrames(*MustMakeScene(name, WithCount(50)), 5);
    EXPECT_EQ(hash, HashOfFrames(*MustMakeScene(name, WithCount(50)), 5));
    EXPECT_NE(hash, HashOfFrames(*MustMakeScene(name, other), 5));
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

TEST(MakeScene, AnUnknownNameListsTheNearestFirst) {
  EXPECT_THAT(MakeScene("wave", {}).status().message(),
              HasSubstr("unknown scene 'wave', must be one of waves, brownian, "));
}

TEST(MakeScene, TheErrorNamesAnOptionThatIsNotFiniteOrNegative) {
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

TEST(MakeScene, MoreObjectsThanTheMaximumAreRefused) {
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
    EXPECT_EQ(scene->aabbs().empty(), name != "one" && name != "two") << name;
    EXPECT_EQ(scene->frame_index(), 1U);
  }
}

TEST(MakeScene, ExtremeValidOptionsKeepEveryBoxFinite) {
  SceneOptions options = WithCount(20);
  options.fixed_step_s = 1;
  options.speed = 1e6F;
  options.gravity = 1e6F;
  options.half_extent_max = options.world_half_extent;
  for (const std::string_view name : SceneNames(SceneGroup::kReference)) {
    const std::unique_ptr<Scene> scene = MustMakeScene(name, options);
    StepTimes(*scene, 500);
    for (const Aabb& box : scene->aabbs()) EXPECT_TRUE(IsValid(box)) << name;
  }
}

TEST(SceneOptions, NoFrameHasMoreThanTheLargestNumberOfObjects) {
  SceneOptions options;
  options.object_count = 128;
  for (const std::string_view name : SceneNames()) {
    const auto scene = MakeScene(name, options);
    ASSERT_TRUE(scene.ok()) << name;
    const size_t max = (*scene)->max_object_count();
    size_t seen = 0;
    for (int frame = 0; frame < 500; ++frame, (*scene)->Step()) {
      EXPECT_EQ((*scene)->max_object_count(), max) << name;
      seen = std::max(seen, (*scene)->aabbs().size());
    }
    EXPECT_EQ(seen, max) << name;
  }
}

}  // namespace
}  // namespace sweepstake
