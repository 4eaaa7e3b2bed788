#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <vector>

#include "tests/engine_client/scene/scene_fixtures.h"

namespace sweepstake {
namespace {

constexpr std::array<std::string_view, 5> kScenarios = {"brownian", "rotating-gravity", "hurricane",
                                                        "free-fall", "random-gravity"};

float Centre(const Aabb& box, int axis) { return (box.min[axis] + box.max[axis]) / 2; }

double MeanCentre(std::span<const Aabb> boxes, int axis) {
  double sum = 0;
  for (const Aabb& box : boxes) sum += Centre(box, axis);
  return sum / static_cast<double>(boxes.size());
}

// Returns the mean distance that a box moves in the next step.
double MeanMove(Scene& scene) {
  const std::vector<Aabb> before = BoxesOf(scene);
  scene.Step();
  double sum = 0;
  for (size_t i = 0; i < before.size(); ++i) {
    double square = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double move = Centre(scene.aabbs()[i], axis) - Centre(before[i], axis);
      square += move * move;
    }
    sum += std::sqrt(square);
  }
  return sum / static_cast<double>(before.size());
}

TEST(Scenario, TheSameSeedsGiveTheSameBoxesBitForBit) {
  for (const std::string_view name : SceneNames(SceneGroup::kReference)) {
    const uint64_t once = HashOfFrames(*MustMakeScene(name, WithCount(100)), 300);
    const uint64_t again = HashOfFrames(*MustMakeScene(name, WithCount(100)), 300);
    EXPECT_EQ(once, again) << name;
  }
}

// The hashes are equal on every platform and compiler. A change here invalidates every recorded
// comparison.
TEST(Scenario, TheBoxesOfFixedSeedsArePinned) {
  SceneOptions options = WithCount(200);
  options.motion_seed = 2;
  const std::array<std::pair<std::string_view, uint64_t>, 8> golden = {{
      {"brownian", 0xC205D119B153718BU},
      {"rotating-gravity", 0xCDEAD85A47581743U},
      {"hurricane", 0x12A5642A60111544U},
      {"free-fall", 0x761252F3F63E25B0U},
      {"random-gravity", 0xCAEAB3A2DCB64CF1U},
      {"suite-b", 0xB25F19E9130A16B5U},
      {"suite-g", 0x926D1C35B5A710CEU},
      {"suite-h", 0x78C322E86173D958U},
  }};
  for (const auto& [name, hash] : golden) {
    EXPECT_EQ(HashOfFrames(*MustMakeScene(name, options), 600), hash) << name;
  }
}

TEST(Scenario, AnotherMotionSeedKeepsTheSpawnAndChangesTheMotionOfEveryObject) {
  SceneOptions other = WithCount(100);
  other.motion_seed = 2;
  for (const std::string_view name : kScenarios) {
    const std::unique_ptr<Scene> a = MustMakeScene(name, WithCount(100));
    const std::unique_ptr<Scene> b = MustMakeScene(name, other);
    EXPECT_EQ(BoxesOf(*a), BoxesOf(*b)) << name;
    a->Step();
    b->Step();
    for (size_t i = 0; i < 100; ++i) EXPECT_NE(a->aabbs()[i], b->aabbs()[i]) << name << " " << i;
  }
}

TEST(Scenario, AnotherSpawnSeedKeepsTheKicks) {
  SceneOptions other = WithCount(1);
  other.spawn_seed = 2;
  const std::unique_ptr<Scene> a = MustMakeScene("brownian", WithCount(1));
  const std::unique_ptr<Scene> b = MustMakeScene("brownian", other);
  const std::array<Aabb, 2> spawn = {a->aabbs()[0], b->aabbs()[0]};
  EXPECT_NE(spawn[0], spawn[1]);
  a->Step();
  b->Step();
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(Centre(a->aabbs()[0], axis) - Centre(spawn[0], axis),
                Centre(b->aabbs()[0], axis) - Centre(spawn[1], axis), 1e-4);
  }
}

TEST(Scenario, MoreObjectsDoNotChangeTheFirstOnes) {
  for (const std::string_view name : kScenarios) {
    const std::unique_ptr<Scene> few = MustMakeScene(name, WithCount(50));
    const std::unique_ptr<Scene> many = MustMakeScene(name, WithCount(80));
    StepTimes(*few, 200);
    StepTimes(*many, 200);
    EXPECT_TRUE(std::equal(few->aabbs().begin(), few->aabbs().end(), many->aabbs().begin()))
        << name;
  }
}

// Returns how far centres may lie outside the world. In the reference hurricane this is about a
// twentieth of the radius.
double Overhang(const Scene& scene) {
  return scene.name() == "suite-h" ? 0.026 * scene.world().max[0] : 1e-3;
}

TEST(Scenario, CentresStayInTheWorld) {
  for (const std::string_view name : SceneNames(SceneGroup::kReference)) {
    const std::unique_ptr<Scene> scene = MustMakeScene(name, WithCount(100));
    const Aabb world = scene->world();
    const double overhang = Overhang(*scene);
    for (int frame = 0; frame < 2000; ++frame) {
      for (const Aabb& box : scene->aabbs()) {
        for (int axis = 0; axis < 3; ++axis) {
          ASSERT_GE(Centre(box, axis), world.min[axis] - overhang) << name << " frame " << frame;
          ASSERT_LE(Centre(box, axis), world.max[axis] + overhang) << name << " frame " << frame;
        }
      }
      scene->Step();
    }
  }
}

TEST(Scenario, SizesAreHeterogeneousWithinTheirRangeAndNeverChange) {
  const SceneOptions options = WithCount(1000);
  for (const std::string_view name : kScenarios) {
    const std::unique_ptr<Scene> scene = MustMakeScene(name, options);
    StepTimes(*scene, 100);
    int below_the_geometric_mean = 0;
    for (const Aabb& box : scene->aabbs()) {
      const float half_extent = (box.max[0] - box.min[0]) / 2;
      ASSERT_GE(half_extent, options.half_extent_min - 1e-4F) << name;
      ASSERT_LE(half_extent, options.half_extent_max + 1e-4F) << name;
      below_the_geometric_mean += half_extent < 1.118F ? 1 : 0;
    }
    EXPECT_NEAR(below_the_geometric_mean, 500, 80) << name << " must be log-uniform";
  }
}

TEST(Scenario, TheFrameIndexCountsSteps) {
  for (const std::string_view name : SceneNames(SceneGroup::kReference)) {
    const std::unique_ptr<Scene> scene = MustMakeScene(name, WithCount(2));
    EXPECT_EQ(scene->frame_index(), 0U);
    StepTimes(*scene, 5);
    EXPECT_EQ(scene->frame_index(), 5U);
  }
}

TEST(BrownianScene, KicksAreBoundedAndNeverDecay) {
  const SceneOptions options = WithCount(500);
  const std::unique_ptr<Scene> scene = MustMakeScene("brownian", options);
  // The mean length of a vector from the uniform distribution over the cube [-1, 1]^3 is 0.9606.
  const double kick = options.speed * options.fixed_step_s;
  EXPECT_NEAR(MeanMove(*scene), 0.9606 * kick, 0.05 * kick);
  StepTimes(*scene, 1000);
  EXPECT_NEAR(MeanMove(*scene), 0.9606 * kick, 0.05 * kick);
}

// Returns the mean distance along x and y that boxes move in the second half of an interval.
std::array<double, 2> MeanWayInSecondHalf(Scene& scene, int steps_per_interval) {
  StepTimes(scene, steps_per_interval / 2);
  const std::array<double, 2> middle = {MeanCentre(scene.aabbs(), 0), MeanCentre(scene.aabbs(), 1)};
  StepTimes(scene, steps_per_interval - steps_per_interval / 2);
  return {MeanCentre(scene.aabbs(), 0) - middle[0], MeanCentre(scene.aabbs(), 1) - middle[1]};
}

void ExpectFourDirectionsInTurn(Scene& scene, int steps_per_interval) {
  constexpr int kAxis[4] = {1, 0, 1, 0};
  constexpr int kSign[4] = {-1, 1, 1, -1};
  for (int interval = 0; interval < 12; ++interval) {
    const std::array<double, 2> way = MeanWayInSecondHalf(scene, steps_per_interval);
    EXPECT_GT(way[kAxis[interval % 4]] * kSign[interval % 4], 0) << "interval " << interval;
  }
}

TEST(RotatingGravityScene, ObjectsFallInFourDirectionsForThreeSecondsEach) {
  ExpectFourDirectionsInTurn(*MustMakeScene("rotating-gravity", WithCount(500)), 180);
}

TEST(RotatingGravityScene, TheDirectionTurnsByTimeNotBySteps) {
  SceneOptions fine = WithCount(500);
  fine.fixed_step_s = 1.0F / 240.0F;
  ExpectFourDirectionsInTurn(*MustMakeScene("rotating-gravity", fine), 720);
  SceneOptions quick = WithCount(500);
  quick.direction_interval_s = 2;
  ExpectFourDirectionsInTurn(*MustMakeScene("rotating-gravity", quick), 120);
}

TEST(RotatingGravityScene, ObjectsKeepMovingAndStaySpreadOut) {
  const std::unique_ptr<Scene> scene = MustMakeScene("rotating-gravity", WithCount(500));
  StepTimes(*scene, 60 * 120);
  EXPECT_GT(MeanMove(*scene), 0.02);
  for (int axis = 0; axis < 3; ++axis) {
    const double mean = MeanCentre(scene->aabbs(), axis);
    double square = 0;
    for (const Aabb& box : scene->aabbs()) square += std::pow(Centre(box, axis) - mean, 2);
    EXPECT_GT(std::sqrt(square / 500), 2) << "axis " << axis;
  }
}

TEST(FreeFallScene, ObjectsComeToRestOnTheFloor) {
  const std::unique_ptr<Scene> scene = MustMakeScene("free-fall", WithCount(500));
  StepTimes(*scene, 60 * 60);
  for (const Aabb& box : scene->aabbs()) EXPECT_NEAR(box.min[1], -50, 0.01);
  EXPECT_LT(MeanMove(*scene), 1e-3);
}

TEST(FreeFallScene, ABodyFallsWithTheGravity) {
  SceneOptions options = WithCount(200);
  options.speed = 0;
  const std::unique_ptr<Scene> scene = MustMakeScene("free-fall", options);
  const std::vector<Aabb> spawn = BoxesOf(*scene);
  StepTimes(*scene, 60);
  for (size_t i = 0; i < spawn.size(); ++i) {
    if (spawn[i].min[1] < -44) continue;
    // Semi-implicit steps give (n + 1) / n times the exact distance of the fall.
    EXPECT_NEAR(Centre(spawn[i], 1) - Centre(scene->aabbs()[i], 1), 0.5 * 9.81 * 61 / 60, 1e-3);
  }
}

TEST(RandomGravityScene, ObjectsLeaveInAllDirectionsAndComeToRestAtTheWalls) {
  SceneOptions options = WithCount(500);
  options.speed = 0;
  const std::unique_ptr<Scene> scene = MustMakeScene("random-gravity", options);
  const std::vector<Aabb> spawn = BoxesOf(*scene);
  StepTimes(*scene, 30);
  for (int axis = 0; axis < 3; ++axis) {
    int upwards = 0;
    for (size_t i = 0; i < spawn.size(); ++i) {
      upwards += Centre(scene->aabbs()[i], axis) > Centre(spawn[i], axis) ? 1 : 0;
    }
    EXPECT_NEAR(upwards, 250, 60) << "axis " << axis;
  }
  StepTimes(*scene, 60 * 120);
  EXPECT_LT(MeanMove(*scene), 0.01);
}

double AxisDistance(const Aabb& box) { return std::hypot(Centre(box, 0), Centre(box, 2)); }

// Returns the distance moved around the axis in one step, averaged over objects between two
// distances from the axis.
double MeanTangentialMove(Scene& scene, double nearest, double farthest) {
  const std::vector<Aabb> before = BoxesOf(scene);
  scene.Step();
  double sum = 0;
  int count = 0;
  for (size_t i = 0; i < before.size(); ++i) {
    const double distance = AxisDistance(before[i]);
    if (distance < nearest || distance > farthest) continue;
    const double x = Centre(before[i], 0);
    const double z = Centre(before[i], 2);
    const Aabb& after = scene.aabbs()[i];
    sum += (x * (Centre(after, 2) - z) - z * (Centre(after, 0) - x)) / distance;
    ++count;
  }
  return sum / count;
}

TEST(HurricaneScene, ObjectsOrbitOneWayAndFasterTowardsTheAxis) {
  const std::unique_ptr<Scene> scene = MustMakeScene("hurricane", WithCount(3000));
  const double inner = MeanTangentialMove(*scene, 6, 12);
  const double outer = MeanTangentialMove(*scene, 30, 45);
  EXPECT_GT(outer, 0.5);
  EXPECT_GT(inner, 1.5 * outer);
}

TEST(HurricaneScene, ObjectsKeepTheirDistanceFromTheAxisWithinElevenPercent) {
  const std::unique_ptr<Scene> scene = MustMakeScene("hurricane", WithCount(500));
  const std::vector<Aabb> spawn = BoxesOf(*scene);
  StepTimes(*scene, 1000);
  for (size_t i = 0; i < spawn.size(); ++i) {
    const double before = AxisDistance(spawn[i]);
    EXPECT_NEAR(AxisDistance(scene->aabbs()[i]), before, 0.11 * before + 1e-3);
  }
}

}  // namespace
}  // namespace sweepstake
