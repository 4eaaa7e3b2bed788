// Tests the core of `sweepstake-lab check`: its oracle agrees with the definition of overlap, and
// it detects wrong backends.
#include "tests/laboratory/game/pair_oracle.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "engine_client/cli/game/scene_choice.h"
#include "tests/support/pair_oracle.h"

namespace sweepstake::cli {
namespace {

// Finds the right pairs, but falsifies them from a certain frame on.
class WrongBackend : public BroadPhase {
 public:
  using Spoil = void (*)(std::vector<OverlapPair>& pairs);

  WrongBackend(uint64_t first_wrong_frame, Spoil spoil)
      : first_wrong_frame_(first_wrong_frame), spoil_(spoil) {}

  std::string_view name() const override { return "Wrong"; }
  uint32_t version() const override { return 1; }
  void DoBuild(std::span<const Aabb> boxes) override { boxes_.assign(boxes.begin(), boxes.end()); }
  void DoUpdate(std::span<const Aabb> boxes) override {
    boxes_.assign(boxes.begin(), boxes.end());
    ++frame_;
  }
  void DoFindPairs(PairBuffer& out) override {
    std::vector<OverlapPair> pairs = test_support::ScalarPairs(boxes_);
    if (frame_ >= first_wrong_frame_) spoil_(pairs);
    for (const OverlapPair& pair : pairs) out.Append(pair);
  }
  uint64_t aabb_check_count() const override { return 0; }
  size_t native_bytes() const override { return 0; }

 private:
  uint64_t first_wrong_frame_;
  Spoil spoil_;
  uint64_t frame_ = 0;
  std::vector<Aabb> boxes_;
};

std::unique_ptr<Scene> Brownian(uint32_t object_count) {
  return std::move(*OpenScene({"suite-b", object_count, 1}));
}

ArmCheck JudgeWrong(WrongBackend::Spoil spoil) {
  const auto scene = Brownian(200);
  std::vector<std::unique_ptr<BroadPhase>> arms;
  arms.push_back(std::make_unique<WrongBackend>(3, spoil));
  return CheckScene(*scene, arms, 10, [](uint64_t) {})->front();
}

TEST(PairOracle, AgreesWithTheDefinitionInEveryDegenerateSceneAndFrame) {
  PairOracle oracle;
  for (const std::string_view name : SceneNames(SceneGroup::kDegenerate)) {
    const auto scene = std::move(*OpenScene({std::string(name), 150, 5}));
    for (int frame = 0; frame < 20; ++frame) {
      const auto found = oracle.Find(scene->aabbs());
      ASSERT_TRUE(std::ranges::equal(found, test_support::ScalarPairs(scene->aabbs())))
          << name << " in frame " << frame;
      scene->Step();
    }
  }
}

TEST(PairOracle, AgreesWithTheDefinitionInEveryScene) {
  PairOracle oracle;
  for (const std::string_view name : SceneNames(SceneGroup::kReference)) {
    const auto scene = std::move(*OpenScene({std::string(name), 400, 2}));
    for (int frame = 0; frame < 10; ++frame) {
      ASSERT_TRUE(std::ranges::equal(oracle.Find(scene->aabbs()),
                                     test_support::ScalarPairs(scene->aabbs())))
          << name << " in frame " << frame;
      scene->Step();
    }
  }
}

TEST(CheckScene, PassesABackendThatIsRightInEveryFrame) {
  const auto scene = Brownian(200);
  std::vector<std::unique_ptr<BroadPhase>> arms;
  arms.push_back(std::make_unique<WrongBackend>(100, [](auto& pairs) { pairs.clear(); }));
  uint64_t heard = 0;
  const auto checks = *CheckScene(*scene, arms, 10, [&](uint64_t done) { heard = done; });
  EXPECT_FALSE(checks.front().first_difference);
  EXPECT_EQ(checks.front().frame_count, 11U);
  EXPECT_GT(checks.front().pair_count, 0U);
  EXPECT_EQ(heard, 11U);
}

TEST(CheckScene, RefusesAFrameWithTooManyPairsBeforeAnyArmHearsOfIt) {
  const auto scene = std::move(*OpenScene({"all-coincident", 101, 1}));
  std::vector<std::unique_ptr<BroadPhase>> arms;
  arms.push_back(std::make_unique<WrongBackend>(0, [](auto& pairs) { pairs.clear(); }));
  const auto checks = CheckScene(
      *scene, arms, 10, [](uint64_t) {}, 5049);
  EXPECT_EQ(checks.status().code(), StatusCode::kResourceExhausted);
  EXPECT_NE(checks.status().message().find("frame 0"), std::string::npos);
  EXPECT_NE(checks.status().message().find("5049"), std::string::npos);
  EXPECT_TRUE(CheckScene(
                  *scene, arms, 10, [](uint64_t) {}, 5050)
                  .ok());
}

TEST(CheckScene, NamesTheFirstFrameWithAMissingPair) {
  const ArmCheck check = JudgeWrong([](auto& pairs) { pairs.pop_back(); });
  ASSERT_TRUE(check.first_difference);
  EXPECT_EQ(check.first_difference->frame, 3U);
  EXPECT_EQ(check.first_difference->pairs.missing.size(), 1U);
  EXPECT_TRUE(check.first_difference->pairs.extra.empty());
  EXPECT_EQ(check.frame_count, 3U);
}

TEST(CheckScene, FindsAPairThatIsReportedTwice) {
  const ArmCheck check = JudgeWrong([](auto& pairs) { pairs.push_back(pairs.front()); });
  ASSERT_TRUE(check.first_difference);
  EXPECT_TRUE(check.first_difference->pairs.missing.empty());
  EXPECT_EQ(check.first_difference->pairs.extra.size(), 1U);
}

TEST(CheckScene, FindsAPairThatIsTheWrongWayAround) {
  const ArmCheck check =
      JudgeWrong([](auto& pairs) { std::swap(pairs.front().a, pairs.front().b); });
  ASSERT_TRUE(check.first_difference);
  EXPECT_EQ(check.first_difference->pairs.missing.size(), 1U);
  EXPECT_EQ(check.first_difference->pairs.extra.size(), 1U);
}

TEST(CheckScene, FindsAnotherPairInPlaceOfTheRightOneThoughTheCountIsRight) {
  const ArmCheck check = JudgeWrong([](auto& pairs) { pairs.front() = {198, 4'000'000'000U}; });
  ASSERT_TRUE(check.first_difference);
  EXPECT_EQ(check.first_difference->pairs.missing.size(), 1U);
  EXPECT_EQ(check.first_difference->pairs.extra.size(), 1U);
}

TEST(ExpandScenes, MultipliesScenesByCountsAndTakesAFileOnce) {
  const auto choices = ExpandScenes({"suite-b", "x.aabbs"}, {10, 20}, 3);
  ASSERT_EQ(choices.size(), 3U);
  EXPECT_EQ(choices[1].name, "suite-b");
  EXPECT_EQ(choices[1].object_count, 20U);
  EXPECT_EQ(choices[2].name, "x.aabbs");
}

TEST(ExpandScenes, KnowsTheWordsForManyScenes) {
  EXPECT_EQ(ExpandScenes({"all"}, {10}, 1).size(), SceneNames(SceneGroup::kReference).size());
  EXPECT_EQ(ExpandScenes({"changing"}, {10}, 1).size(), SceneNames(SceneGroup::kChanging).size());
  EXPECT_EQ(ExpandScenes({"degenerate"}, {10}, 1).size(),
            SceneNames(SceneGroup::kDegenerate).size() - 1);
  const auto mixtures = ExpandScenes({"mixtures"}, {10}, 7);
  ASSERT_EQ(mixtures.size(), 10U);
  EXPECT_EQ(mixtures.front().seed, 7U);
  EXPECT_EQ(mixtures.back().seed, 16U);
}

TEST(OpenScene, PrefersTheScenarioWhereAKindOfBoxesHasItsName) {
  const auto opened = std::move(*OpenScene({"brownian", 20, 1}));
  const auto scenario = std::move(*MakeScene("brownian", {.object_count = 20}));
  EXPECT_TRUE(std::ranges::equal(opened->aabbs(), scenario->aabbs()));
}

TEST(OpenScene, ListsEveryNameForAnUnknownOne) {
  const auto scene = OpenScene({"no\nwhere", 20, 1});
  ASSERT_FALSE(scene.ok());
  EXPECT_EQ(scene.status().code(), StatusCode::kNotFound);
  EXPECT_NE(scene.status().message().find("'no?where'"), std::string::npos);
  for (const std::string_view name : SceneNames()) {
    EXPECT_NE(scene.status().message().find(name), std::string::npos) << name;
    EXPECT_NE(SceneHelp().find(name), std::string::npos) << name;
  }
}

TEST(OpenScene, SpawnsAndRemovesASixtyFourthPerFrame) {
  const auto scene = std::move(*OpenScene({"spawning", 640, 1}));
  EXPECT_EQ(scene->aabbs().size(), 640U);
  scene->Step();
  EXPECT_EQ(scene->aabbs().size(), 630U);
  for (int step = 1; step < 32; ++step) scene->Step();
  EXPECT_EQ(scene->aabbs().size(), 320U);
  for (int step = 32; step < 64; ++step) scene->Step();
  EXPECT_EQ(scene->aabbs().size(), 640U);
}

TEST(OpenScene, MovesOneObjectInAHundredInFewMoving) {
  const auto scene = std::move(*OpenScene({"few-moving", 10'000, 1}));
  const std::vector<Aabb> before(scene->aabbs().begin(), scene->aabbs().end());
  scene->Step();
  size_t moved = 0;
  for (size_t i = 0; i < before.size(); ++i) moved += before[i] == scene->aabbs()[i] ? 0 : 1;
  EXPECT_GT(moved, 50U);
  EXPECT_LT(moved, 200U);
}

TEST(ChooseArms, ListsTheBackendsForAnUnknownName) {
  const auto arms = ChooseArms({"SAP", "Octree"});
  ASSERT_FALSE(arms.ok());
  EXPECT_EQ(arms.status().code(), StatusCode::kNotFound);
  for (const std::string_view name : BroadPhaseNames()) {
    EXPECT_NE(arms.status().message().find(name), std::string::npos) << name;
  }
}

TEST(ChooseArms, TakesAnArmOnceAndAllInTheirOrder) {
  EXPECT_EQ(*ChooseArms({"SAP", "SAP"}), std::vector<std::string>{"SAP"});
  EXPECT_EQ(ChooseArms({"all"})->size(), BroadPhaseNames().size());
}

}  // namespace
}  // namespace sweepstake::cli
