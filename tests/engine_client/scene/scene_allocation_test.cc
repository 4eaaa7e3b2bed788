#include <gtest/gtest.h>

#include "tests/engine_client/scene/file_fixtures.h"
#include "tests/engine_client/scene/scene_fixtures.h"
#include "tests/support/allocation_counter.h"

namespace sweepstake {
namespace {

uint64_t AllocationsOfSteps(Scene& scene, int count) {
  const uint64_t before = test_support::ThreadAllocationCount();
  StepTimes(scene, count);
  return test_support::ThreadAllocationCount() - before;
}

TEST(SceneAllocation, TheCounterCountsTheCreationOfAScene) {
  const uint64_t before = test_support::ThreadAllocationCount();
  MustMakeScene("brownian", WithCount(10));
  EXPECT_GT(test_support::ThreadAllocationCount(), before);
}

TEST(SceneAllocation, StepsOfComputedScenesDoNotAllocate) {
  for (const std::string_view name : SceneNames()) {
    const std::unique_ptr<Scene> scene = MustMakeScene(name, WithCount(300));
    EXPECT_EQ(AllocationsOfSteps(*scene, 200), 0U) << name;
  }
}

class RecordedSceneAllocation : public FileTest {};

TEST_F(RecordedSceneAllocation, StepsAndRestartsOfRecordedScenesDoNotAllocate) {
  const auto path = PathOf("scene.aabbs");
  ScriptedScene changing({{BoxAt(0)}, {}, {BoxAt(1), BoxAt(2)}});
  ASSERT_TRUE(RecordScene(changing, 2, path.string()).ok());
  EXPECT_EQ(AllocationsOfSteps(*MustMakeScene(path.string(), {}), 10), 0U);
  ASSERT_TRUE(RecordScene(*MustMakeScene("suite-g", WithCount(500)), 20, path.string()).ok());
  EXPECT_EQ(AllocationsOfSteps(*MustMakeScene(path.string(), {}), 100), 0U);
}

}  // namespace
}  // namespace sweepstake
