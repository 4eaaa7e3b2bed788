// Each kernel is compiled for several instruction sets: all must find what the scalar definition
// says.
#include <gtest/gtest.h>

#include "engine_client/scene/box_scenes.h"
#include "hwy/highway.h"
#include "tests/engine_client/broad_phase/backend_under_test.h"

namespace sweepstake {
namespace {

using test_support::FindPairsError;
using test_support::MakeOrThrow;

class OnEachInstructionSet : public testing::TestWithParam<std::string_view> {
 protected:
  void TearDown() override {
    hwy::SetSupportedTargetsForTest(0);  // what the machine has
  }

  // Describes the first scene with an error when all targets but `target` are disabled.
  std::string VerdictOn(int64_t target) {
    hwy::SetSupportedTargetsForTest(target);
    for (const std::string_view name : SceneNames(SceneGroup::kDegenerate)) {
      const auto scene = MakeDegenerateScene(name, 333, 6);
      const auto backend = MakeOrThrow(GetParam());
      backend->Build(scene->aabbs());
      for (int frame = 0; frame < 6; ++frame) {
        const std::string verdict = FindPairsError(*backend, scene->aabbs(), pairs_);
        if (!verdict.empty()) return std::string(name) + ": " + verdict;
        scene->Step();
        backend->Update(scene->aabbs());
      }
    }
    return "";
  }

  PairBuffer pairs_;
};

TEST_P(OnEachInstructionSet, FindsTheSamePairs) {
  int64_t remaining = hwy::SupportedTargets();
  ASSERT_NE(remaining, 0);
  while (remaining != 0) {
    const int64_t target = remaining & -remaining;
    remaining &= ~target;
    EXPECT_EQ(VerdictOn(target), "") << "on " << hwy::TargetName(target);
  }
}

INSTANTIATE_TEST_SUITE_P(, OnEachInstructionSet,
                         testing::ValuesIn(BroadPhaseNames().begin(), BroadPhaseNames().end()),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace sweepstake
