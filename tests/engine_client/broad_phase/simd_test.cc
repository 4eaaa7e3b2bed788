// Each kernel is compiled for several instruction sets; all must find the pairs of the scalar
// definition, and must clear the upper halves of the vector registers.
#include "sweepstake/simd.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string>
#include <string_view>

#include "engine_client/broad_phase/common/compress_table.h"
#include "engine_client/scene/box_scenes.h"
#include "tests/engine_client/broad_phase/backend_under_test.h"
#include "tests/engine_client/broad_phase/each_simd_target.h"

namespace sweepstake {
namespace {

using test_support::FindPairsError;
using test_support::MakeOrThrow;
using test_support::OnEachSimdTarget;

// If all these boxes are in one place, a leaf of KDTree has more near leaves than it tests at once.
constexpr uint32_t kBoxes = 611;

class OnEachInstructionSet : public testing::TestWithParam<std::string_view> {
 protected:
  // Returns the name of the first scene with an error and the error, or "" if there is none.
  std::string Verdict() {
    for (const std::string_view name : SceneNames(SceneGroup::kDegenerate)) {
      const auto scene = MakeDegenerateScene(name, kBoxes, 6);
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
  OnEachSimdTarget([this] { EXPECT_EQ(Verdict(), ""); });
}

#if defined(__x86_64__)

// XGETBV with index 1 shows which register states are in use (Intel SDM vol. 1, 13.1).
bool ShowsStatesInUse() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string word; info >> word;) {
    if (word == "xgetbv1") return true;
  }
  return false;
}

bool AreUpperHalvesInUse() {
  constexpr uint32_t kUpperHalves = 1U << 2 | 1U << 6;  // of ymm0-15 and of zmm0-15
  uint32_t states = 0;
  asm volatile("xgetbv" : "=a"(states) : "c"(1) : "edx");
  return (states & kUpperHalves) != 0;
}

void ClearUpperHalves() { asm volatile("vzeroupper"); }

// If values stay in the upper halves, all SSE code that follows, of the library and of the game,
// takes up to twice as long.
TEST_P(OnEachInstructionSet, ClearsTheUpperHalvesOfRegisters) {
  if (!ShowsStatesInUse()) GTEST_SKIP() << "this processor does not show which states are in use";
  OnEachSimdTarget([this] {
    const auto backend = MakeOrThrow(GetParam());
    const auto expect_clear = [](std::string_view call) {
      EXPECT_FALSE(AreUpperHalvesInUse()) << call;
      ClearUpperHalves();
    };
    // Grid and Tracy stretch the axes of crowds.
    for (const std::string_view kind : {"brownian", "far-crowds"}) {
      BoxScene scene(kind, kBoxes, 1);
      ClearUpperHalves();
      backend->Build(scene.boxes());
      expect_clear("Build");
      for (int frame = 0; frame < 20; ++frame) {
        scene.Step();
        ClearUpperHalves();
        backend->Update(scene.boxes());
        expect_clear("Update");
        pairs_.Clear();
        backend->FindPairs(pairs_);
        expect_clear("FindPairs");
      }
    }
  });
}

#endif

INSTANTIATE_TEST_SUITE_P(, OnEachInstructionSet,
                         testing::ValuesIn(BroadPhaseNames().begin(), BroadPhaseNames().end()),
                         [](const auto& test) { return std::string(test.param); });

TEST(CompressTable, HasTheLanesOfEachMaskInTheirOrder) {
  for (size_t mask = 0; mask < kCompressTable.of8.size(); ++mask) {
    size_t at = 0;
    for (size_t lane = 0; lane < 8; ++lane) {
      if ((mask & size_t{1} << lane) == 0) continue;
      EXPECT_EQ(kCompressTable.of8[mask][at], lane) << mask;
      for (size_t byte = 0; mask < 16 && byte < 4; ++byte)
        EXPECT_EQ(kCompressTable.bytes_of4[mask][4 * at + byte], 4 * lane + byte) << mask;
      ++at;
    }
  }
}

TEST(SimdTargets, AreListedOnceAndTheBestIsTheDefault) {
  ASSERT_FALSE(SimdTargets().empty());
  const char* const asked_for = std::getenv("SWEEPSTAKE_CLIENT_SIMD");
  EXPECT_EQ(SimdTarget(),
            asked_for != nullptr && *asked_for != 0 ? asked_for : SimdTargets().front());
  for (const std::string_view name : SimdTargets())
    EXPECT_EQ(std::ranges::count(SimdTargets(), name), 1) << name;
}

TEST(SimdTargets, AnUnknownTargetListsTheValidOnesAndChangesNothing) {
  const std::string_view before = SimdTarget();
  for (const std::string_view name : {"", "AVX2", "avx3", "mmx"}) {
    const Status status = UseSimdTarget(name);
    EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
    EXPECT_THAT(status.message(), testing::HasSubstr(std::string(SimdTargets().back())));
    EXPECT_EQ(SimdTarget(), before);
  }
}

}  // namespace
}  // namespace sweepstake
