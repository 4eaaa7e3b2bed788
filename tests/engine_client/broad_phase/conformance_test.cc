// Compares every backend's pairs with the definition of overlap, pair by pair, over many frames.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>
#include <tuple>

#include "engine_client/scene/box_scenes.h"
#include "engine_client/scene/changing_scenes.h"
#include "sweepstake/broad_phase.h"
#include "tests/engine_client/broad_phase/backend_under_test.h"

namespace sweepstake {
namespace {

using test_support::FindPairsError;
using test_support::MakeOrThrow;
using test_support::SequenceError;

std::string ParameterName(std::string name) {
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

// Returns the first `count` boxes of the scene, or all if it has fewer.
std::span<const Aabb> FirstOf(const Scene& scene, size_t count) {
  return scene.aabbs().first(std::min(count, scene.aabbs().size()));
}

class EveryBackend : public testing::TestWithParam<std::string_view> {
 protected:
  std::unique_ptr<BroadPhase> backend_ = MakeOrThrow(GetParam());
  PairBuffer pairs_;
};

class EveryBackendInEveryScene
    : public testing::TestWithParam<std::tuple<std::string_view, std::string_view>> {
 protected:
  std::unique_ptr<BroadPhase> backend_ = MakeOrThrow(std::get<0>(GetParam()));
  std::string_view scene_name_ = std::get<1>(GetParam());
  PairBuffer pairs_;
};

TEST_P(EveryBackendInEveryScene, FindsEachOverlappingPairOnceInEachFrame) {
  for (const uint32_t count : {0, 1, 2, 3, 4, 5, 15, 16, 17, 33, 64, 65, 200, 611}) {
    const auto scene = MakeDegenerateScene(scene_name_, count, 1000 + count);
    backend_->Build(scene->aabbs());
    for (int frame = 0; frame < 16; ++frame) {
      ASSERT_EQ(FindPairsError(*backend_, scene->aabbs(), pairs_), "")
          << "of " << count << " boxes in frame " << frame;
      scene->Step();
      backend_->Update(scene->aabbs());
    }
  }
}

TEST_P(EveryBackendInEveryScene, FindsAllPairsIfTheCountChangesInEachFrame) {
  const auto scene = MakeDegenerateScene(scene_name_, 300, 77);
  SequentialRandom random(5);
  for (int frame = 0; frame < 40; ++frame) {
    const auto boxes = FirstOf(*scene, random.Below(301));
    backend_->Build(boxes);
    ASSERT_EQ(FindPairsError(*backend_, boxes, pairs_), "")
        << "of " << boxes.size() << " boxes in frame " << frame;
    scene->Step();
  }
}

TEST_P(EveryBackendInEveryScene, FindsAllPairsAfterUpdatesWithoutASearch) {
  const auto scene = MakeDegenerateScene(scene_name_, 150, 31);
  backend_->Build(scene->aabbs());
  for (int round = 0; round < 6; ++round) {
    for (int frame = 0; frame < round; ++frame) {
      scene->Step();
      backend_->Update(scene->aabbs());
    }
    ASSERT_EQ(FindPairsError(*backend_, scene->aabbs(), pairs_), "") << "in round " << round;
    scene->Step();
    backend_->Update(scene->aabbs());
  }
}

TEST_P(EveryBackendInEveryScene, BuildAndUpdateResetTheCheckCount) {
  const auto fresh = MakeOrThrow(std::get<0>(GetParam()));
  PairBuffer fresh_pairs;
  const auto scene = MakeDegenerateScene(scene_name_, 200, 21);
  for (int frame = 0; frame < 4; ++frame) {
    backend_->Build(scene->aabbs());
    backend_->FindPairs(pairs_);
    scene->Step();
    backend_->Update(scene->aabbs());
    backend_->FindPairs(pairs_);
    scene->Step();
  }
  backend_->Build(scene->aabbs());
  fresh->Build(scene->aabbs());
  EXPECT_EQ(backend_->aabb_check_count(), fresh->aabb_check_count());
  backend_->FindPairs(pairs_);
  fresh->FindPairs(fresh_pairs);
  EXPECT_EQ(backend_->aabb_check_count(), fresh->aabb_check_count());
}

TEST_P(EveryBackendInEveryScene, FindsTheSameSequenceAfterTheSameFrames) {
  const auto twin = MakeOrThrow(std::get<0>(GetParam()));
  const auto scene = MakeDegenerateScene(scene_name_, 250, 9);
  backend_->Build(scene->aabbs());
  twin->Build(scene->aabbs());
  for (int frame = 0; frame < 10; ++frame) {
    ASSERT_EQ(SequenceError(*backend_, *twin, pairs_), "") << "in frame " << frame;
    scene->Step();
    backend_->Update(scene->aabbs());
    twin->Update(scene->aabbs());
  }
}

INSTANTIATE_TEST_SUITE_P(
    , EveryBackendInEveryScene,
    testing::Combine(testing::ValuesIn(BroadPhaseNames().begin(), BroadPhaseNames().end()),
                     testing::ValuesIn(SceneNames(SceneGroup::kDegenerate).begin(),
                                       SceneNames(SceneGroup::kDegenerate).end())),
    [](const auto& test) {
      return ParameterName(std::string(std::get<0>(test.param)) + "_" +
                           std::string(std::get<1>(test.param)));
    });

std::vector<OverlapPair> PairsOfFrame(BroadPhase& backend, std::span<const Aabb> boxes, int frame) {
  PairBuffer pairs;
  frame == 0 ? backend.Build(boxes) : backend.Update(boxes);
  backend.FindPairs(pairs);
  return {pairs.pairs().begin(), pairs.pairs().end()};
}

TEST_P(EveryBackend, HasItsNameAndAVersion) {
  EXPECT_EQ(backend_->name(), GetParam());
  EXPECT_GE(backend_->version(), 1U);
}

TEST_P(EveryBackend, FindsAllPairsInMixturesFromManySeeds) {
  for (uint64_t seed = 1; seed <= 40; ++seed) {
    BoxScene scene("mixture", 20 + 7 * seed, seed);
    backend_->Build(scene.boxes());
    for (int frame = 0; frame < 12; ++frame) {
      ASSERT_EQ(FindPairsError(*backend_, scene.boxes(), pairs_), "")
          << "with seed " << seed << " in frame " << frame;
      scene.Step();
      backend_->Update(scene.boxes());
    }
  }
}

TEST_P(EveryBackend, FindsAllPairsWhenTheSceneIsReplaced) {
  for (const std::string_view name : SceneNames(SceneGroup::kDegenerate)) {
    const auto scene = MakeDegenerateScene(name, 120, 3);
    backend_->Build(scene->aabbs());
    for (const std::string_view next : SceneNames(SceneGroup::kDegenerate)) {
      const auto other = MakeDegenerateScene(next, 120, 4);
      backend_->Update(other->aabbs());
      ASSERT_EQ(FindPairsError(*backend_, other->aabbs(), pairs_), "")
          << "from " << name << " to " << next;
    }
  }
}

TEST_P(EveryBackend, FindsAllPairsInEveryRegimeOfEveryChangingScene) {
  for (const std::string_view name : SceneNames(SceneGroup::kChanging)) {
    constexpr uint32_t kRegimeFrames = 9;
    const auto scene = MakeChangingScene(name, 200, 8, kRegimeFrames);
    backend_->Build(scene->aabbs());
    for (int frame = 0; frame < 72; ++frame) {
      ASSERT_EQ(FindPairsError(*backend_, scene->aabbs(), pairs_), "") << "in " << name << frame;
      scene->Step();
      backend_->Update(scene->aabbs());
    }
  }
}

TEST_P(EveryBackend, FindsAllPairsInThreeHundredFrames) {
  BoxScene scene("brownian", 200, 12);
  backend_->Build(scene.boxes());
  for (int frame = 0; frame < 300; ++frame) {
    ASSERT_EQ(FindPairsError(*backend_, scene.boxes(), pairs_), "") << "in frame " << frame;
    scene.Step();
    backend_->Update(scene.boxes());
  }
}

TEST_P(EveryBackend, FindsAllPairsWhileObjectsAreAddedAndRemoved) {
  for (const std::string_view name : SceneNames(SceneGroup::kDegenerate)) {
    const auto scene = MakeDegenerateScene(name, 400, 5);
    backend_->Build(FirstOf(*scene, 100));
    for (const size_t count : {101, 100, 130, 130, 400, 399, 90, 0, 1, 17, 300, 0, 0, 250}) {
      scene->Step();
      backend_->Update(FirstOf(*scene, count));
      ASSERT_EQ(FindPairsError(*backend_, FirstOf(*scene, count), pairs_), "")
          << "in " << name << " with " << count << " objects";
    }
  }
}

// The order of the pairs must be equal, too, so that a game's results do not depend on the machine.
TEST_P(EveryBackend, FindsTheSamePairsWithAnyNumberOfThreads) {
  for (const std::string_view kind : {"brownian", "mixture", "clusters", "long-thin"}) {
    BoxScene scene(kind, 9000, 6);
    const auto pool_of_two = MakeThreadPool(2);
    const auto pool_of_three = MakeThreadPool(3);
    const auto with_two = std::move(*MakeBroadPhase(GetParam(), {pool_of_two.get()}));
    const auto with_three = std::move(*MakeBroadPhase(GetParam(), {pool_of_three.get()}));
    for (int frame = 0; frame < 4; ++frame, scene.Step()) {
      const std::vector<OverlapPair> alone = PairsOfFrame(*backend_, scene.boxes(), frame);
      EXPECT_FALSE(alone.empty());
      EXPECT_EQ(PairsOfFrame(*with_two, scene.boxes(), frame), alone) << kind << frame;
      EXPECT_EQ(PairsOfFrame(*with_three, scene.boxes(), frame), alone) << kind << frame;
    }
  }
}

// One box becomes invalid and valid again while all others rest. The state that is kept for resting
// boxes must not hide the change.
TEST_P(EveryBackend, FindsAllPairsWhenARestingBoxBecomesInvalidAndValid) {
  const BoxScene scene("brownian", 300, 7);
  std::vector<Aabb> boxes(scene.boxes().begin(), scene.boxes().end());
  boxes[0] = {{-100, -100, -100}, {100, 100, 100}};
  const Aabb whole = boxes[7];
  const float nan = std::numeric_limits<float>::quiet_NaN();
  backend_->Build(boxes);
  for (int frame = 0; frame < 120; ++frame) {
    boxes[7] = whole;
    if (frame % 40 >= 20) std::swap(boxes[7].min[frame % 3], boxes[7].max[frame % 3]);
    if (frame % 40 >= 30) boxes[7].max[1] = nan;
    backend_->Update(boxes);
    ASSERT_EQ(FindPairsError(*backend_, boxes, pairs_), "") << "in frame " << frame;
  }
}

// aabb.h recommends such boxes for objects without bounds.
TEST_P(EveryBackend, FindsAllPairsOfAPlaneWithHugeFiniteFaces) {
  for (const float huge : {1e30F, std::numeric_limits<float>::max()}) {
    BoxScene scene("brownian", 300, 8);
    for (int frame = 0; frame < 40; ++frame, scene.Step()) {
      std::vector<Aabb> boxes(scene.boxes().begin(), scene.boxes().end());
      boxes.push_back({{-huge, -huge, -huge}, {huge, huge, 3}});
      frame == 0 ? backend_->Build(boxes) : backend_->Update(boxes);
      ASSERT_EQ(FindPairsError(*backend_, boxes, pairs_), "") << "in frame " << frame;
      const auto below =
          std::ranges::count_if(scene.boxes(), [](const Aabb& box) { return box.min[2] <= 3; });
      EXPECT_GT(below, 100);
      EXPECT_EQ(std::ranges::count(pairs_.pairs(), 300U, &OverlapPair::b), below);
    }
  }
}

TEST_P(EveryBackend, AppendsToTheContentOfTheBuffer) {
  const Aabb boxes[] = {{{0, 0, 0}, {1, 1, 1}}, {{1, 1, 1}, {2, 2, 2}}};
  backend_->Build(boxes);
  pairs_.Append({7, 8});
  backend_->FindPairs(pairs_);
  ASSERT_EQ(pairs_.size(), 2U);
  EXPECT_EQ(pairs_.pairs()[0], (OverlapPair{7, 8}));
  EXPECT_EQ(pairs_.pairs()[1], (OverlapPair{0, 1}));
}

TEST_P(EveryBackend, FindsAllPairsOfCoincidentBoxes) {
  BoxScene scene("all-coincident", 1000, 1);
  backend_->Build(scene.boxes());
  EXPECT_EQ(FindPairsError(*backend_, scene.boxes(), pairs_), "");
  EXPECT_EQ(pairs_.size(), 1000U * 999 / 2);
  scene.Step();
  backend_->Update(scene.boxes());
  EXPECT_EQ(FindPairsError(*backend_, scene.boxes(), pairs_), "");
}

// Tests every relation that two intervals can have, on three axes at the same time.
TEST_P(EveryBackend, AgreesWithTheDefinitionForAllPositionsOfTwoBoxes) {
  std::vector<std::pair<float, float>> intervals;
  for (int low = 0; low < 4; ++low) {
    for (int high = low; high < 4; ++high) intervals.emplace_back(low, high);
  }
  std::vector<Aabb> boxes;
  for (const auto& x : intervals) {
    for (const auto& y : intervals) {
      for (const auto& z : intervals)
        boxes.push_back({{x.first, y.first, z.first}, {x.second, y.second, z.second}});
    }
  }
  backend_->Build(boxes);
  EXPECT_EQ(FindPairsError(*backend_, boxes, pairs_), "");
}

INSTANTIATE_TEST_SUITE_P(, EveryBackend,
                         testing::ValuesIn(BroadPhaseNames().begin(), BroadPhaseNames().end()),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace sweepstake
