#include "engine_client/scene/changing_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "tests/engine_client/scene/scene_fixtures.h"

namespace sweepstake {
namespace {

const std::span<const std::string_view> kNames = SceneNames(SceneGroup::kChanging);

std::unique_ptr<Scene> Make(std::string_view name, uint32_t object_count, uint64_t seed = 1,
                            uint32_t regime_frames = 0) {
  return MakeChangingScene(name, object_count, seed, regime_frames);
}

struct Step {
  double moved_share;  // share of moved objects among those in both frames
  double mean_move;    // mean distance along x of the objects in both frames
  size_t object_count;
};

Step TakeStep(Scene& scene) {
  const std::vector<Aabb> before = BoxesOf(scene);
  scene.Step();
  const size_t both = std::min(before.size(), scene.aabbs().size());
  double moved = 0;
  double distance = 0;
  for (size_t i = 0; i < both; ++i) {
    moved += before[i] == scene.aabbs()[i] ? 0 : 1;
    distance += std::fabs(scene.aabbs()[i].min[0] - before[i].min[0]);
  }
  return {moved / static_cast<double>(both), distance / static_cast<double>(both),
          scene.aabbs().size()};
}

// Returns the step in the middle of each of the first regimes.
std::vector<Step> MiddleOfRegimes(std::string_view name, uint32_t object_count, int regime_count) {
  constexpr uint32_t kRegimeFrames = 40;
  const auto scene = Make(name, object_count, 3, kRegimeFrames);
  std::vector<Step> steps;
  for (int regime = 0; regime < regime_count; ++regime) {
    StepTimes(*scene, 19);
    steps.push_back(TakeStep(*scene));
    StepTimes(*scene, 20);
  }
  return steps;
}

double Side(const Scene& scene, int axis) {
  float low = std::numeric_limits<float>::max();
  float high = std::numeric_limits<float>::lowest();
  for (const Aabb& box : scene.aabbs()) {
    low = std::min(low, box.min[axis]);
    high = std::max(high, box.max[axis]);
  }
  return static_cast<double>(high) - static_cast<double>(low);
}

// The default number of frames per regime of each scene.
constexpr std::pair<std::string_view, uint32_t> kRegimeFrames[] = {
    {"rest-and-motion", 400},    {"waves", 400},         {"storms", 400},
    {"gather-and-scatter", 300}, {"day-and-night", 500}, {"arrivals", 350}};

TEST(ChangingScenes, RegimesLastTheDefaultNumberOfFrames) {
  ASSERT_EQ(std::size(kRegimeFrames), kNames.size());
  for (const auto& [name, frames] : kRegimeFrames) {
    EXPECT_EQ(HashOfFrames(*Make(name, 50), 2 * frames),
              HashOfFrames(*Make(name, 50, 1, frames), 2 * frames))
        << name;
  }
}

TEST(ChangingScenes, BoxesDependOnlyOnTheSeed) {
  for (const std::string_view name : kNames) {
    const uint64_t once = HashOfFrames(*Make(name, 100, 5, 30), 200);
    EXPECT_EQ(once, HashOfFrames(*Make(name, 100, 5, 30), 200)) << name;
    EXPECT_NE(once, HashOfFrames(*Make(name, 100, 6, 30), 200)) << name;
  }
}

// The hashes are equal on every platform and compiler. A change here invalidates every recorded
// trace.
TEST(ChangingScenes, TheBoxesOfFixedSeedsArePinned) {
  const std::pair<std::string_view, uint64_t> golden[] = {
      {"rest-and-motion", 0xA91E7B704B89B3D8U}, {"waves", 0xAA1FB3823ACEA145U},
      {"storms", 0x9556167567901316U},          {"gather-and-scatter", 0x51A8175D6950F908U},
      {"day-and-night", 0x30DF18CA8076958BU},   {"arrivals", 0x164E35D0B297FAE4U},
  };
  for (const auto& [name, hash] : golden) {
    EXPECT_EQ(HashOfFrames(*Make(name, 200, 1, 25), 220), hash) << name;
  }
}

TEST(ChangingScenes, BoxesStayInTheWorldForManyRegimes) {
  for (const std::string_view name : kNames) {
    const auto scene = Make(name, 150, 2, 100);
    const Aabb world = scene->world();
    for (int frame = 0; frame < 3000; ++frame) {
      for (const Aabb& box : scene->aabbs()) {
        for (int axis = 0; axis < 3; ++axis) {
          ASSERT_GE(box.max[axis], world.min[axis]) << name << " frame " << frame;
          ASSERT_LE(box.min[axis], world.max[axis]) << name << " frame " << frame;
          ASSERT_LT(box.min[axis], box.max[axis]) << name << " frame " << frame;
        }
      }
      scene->Step();
    }
  }
}

TEST(ChangingScenes, NoObjectsAndOneObjectAreValidScenes) {
  for (const std::string_view name : kNames) {
    const auto none = Make(name, 0, 1, 2);
    const auto one = Make(name, 1, 1, 2);
    for (int frame = 0; frame < 12; ++frame) {
      none->Step();
      one->Step();
      EXPECT_TRUE(none->aabbs().empty()) << name;
      EXPECT_EQ(one->aabbs().size(), 1U) << name;
    }
    EXPECT_EQ(none->frame_index(), 12U);
  }
}

TEST(ChangingScenes, ARegimeEndsAfterItsFrames) {
  const auto [name, regime_frames] = kRegimeFrames[0];
  const auto scene = Make(name, 200);
  for (uint32_t step = 1; step <= 4 * regime_frames; ++step) {
    const bool rests = (step - 1) / regime_frames % 2 == 0;
    ASSERT_EQ(TakeStep(*scene).mean_move < 0.01, rests) << "step " << step;
  }
}

TEST(ChangingScenes, WavesHaveFewObjectsThenTeleportAllThenRest) {
  const auto steps = MiddleOfRegimes("waves", 3000, 4);
  EXPECT_EQ(steps[0].object_count, 50U);
  EXPECT_EQ(steps[1].object_count, 3000U);
  EXPECT_NEAR(steps[1].moved_share, 1.0 / 3, 0.05);
  EXPECT_GT(steps[1].mean_move, 1);
  EXPECT_EQ(steps[2].object_count, 3000U);
  EXPECT_LT(steps[2].mean_move, 0.001);
  EXPECT_EQ(steps[3].object_count, 50U);
}

TEST(ChangingScenes, StormsTeleportThenJitter) {
  const auto steps = MiddleOfRegimes("storms", 1000, 2);
  EXPECT_NEAR(steps[0].moved_share, 1.0 / 3, 0.05);
  EXPECT_EQ(steps[1].moved_share, 1);
  EXPECT_NEAR(steps[1].mean_move, 0.05, 0.005);
}

TEST(ChangingScenes, GatherAndScatterShrinksRestsGrowsAndRests) {
  const auto scene = Make("gather-and-scatter", 1000, 1, 50);
  const double wide = Side(*scene, 0);
  StepTimes(*scene, 50);
  const double narrow = Side(*scene, 0);
  EXPECT_NEAR(narrow, 0.6 * wide, 0.1 * wide);
  StepTimes(*scene, 20);
  EXPECT_EQ(TakeStep(*scene).moved_share, 0);
  StepTimes(*scene, 79);
  EXPECT_NEAR(Side(*scene, 0), wide, 0.1 * wide);
  StepTimes(*scene, 20);
  EXPECT_EQ(TakeStep(*scene).moved_share, 0);
}

TEST(ChangingScenes, DayAndNightRotatesAllThenMovesOnePercent) {
  const auto steps = MiddleOfRegimes("day-and-night", 5000, 2);
  EXPECT_GT(steps[0].moved_share, 0.99);
  EXPECT_NEAR(steps[1].moved_share, 0.01, 0.006);
}

TEST(ChangingScenes, ArrivalsAddObjectsThenRestThenFlow) {
  const auto scene = Make("arrivals", 640, 1, 70);
  StepTimes(*scene, 32);
  EXPECT_EQ(scene->aabbs().size(), 320U);
  StepTimes(*scene, 32);
  EXPECT_EQ(scene->aabbs().size(), 640U);
  StepTimes(*scene, 26);
  EXPECT_EQ(TakeStep(*scene).moved_share, 0);
  StepTimes(*scene, 69);
  const std::vector<Aabb> before = BoxesOf(*scene);
  scene->Step();
  const std::vector<Aabb> between = BoxesOf(*scene);
  scene->Step();
  size_t straight = 0;
  for (size_t i = 0; i < before.size(); ++i) {
    const float first = between[i].min[0] - before[i].min[0];
    const float second = scene->aabbs()[i].min[0] - between[i].min[0];
    straight += std::fabs(first - second) < 1e-4F ? 1 : 0;
  }
  EXPECT_GT(straight, 600U) << "all but those at a wall go straight on";
}

}  // namespace
}  // namespace sweepstake
