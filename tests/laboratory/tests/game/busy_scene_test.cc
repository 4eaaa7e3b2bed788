// Tests that other work of a game leaves its scene as it is.
#include "tests/laboratory/game/busy_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>

#include "engine_client/cli/game/scene_choice.h"

namespace sweepstake::cli {
namespace {

std::unique_ptr<Scene> Arrivals() { return std::move(*OpenScene({"arrivals", 50, 7})); }

TEST(BusyScene, ShowsTheBoxesOfItsScene) {
  BusyScene busy(Arrivals(), 1);
  const auto plain = Arrivals();
  EXPECT_EQ(busy.name(), plain->name());
  EXPECT_EQ(busy.world(), plain->world());
  EXPECT_EQ(busy.max_object_count(), plain->max_object_count());
  for (int frame = 0; frame < 10; ++frame) {
    ASSERT_TRUE(std::ranges::equal(busy.aabbs(), plain->aabbs())) << frame;
    busy.Step();
    plain->Step();
    ASSERT_EQ(busy.frame_index(), plain->frame_index());
  }
}

TEST(BusyScene, WorksForItsTimeInEachStep) {
  constexpr auto kWork = std::chrono::milliseconds(2);
  BusyScene busy(Arrivals(), std::chrono::nanoseconds(kWork).count());
  for (int frame = 0; frame < 3; ++frame) {
    const auto start = std::chrono::steady_clock::now();
    busy.Step();
    EXPECT_GE(std::chrono::steady_clock::now() - start, kWork);
  }
}

}  // namespace
}  // namespace sweepstake::cli
