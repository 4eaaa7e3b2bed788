// Tests what only SAP has: a sort on several threads, and an exact sort if too many boxes share an
// interval of the sweep axis.
#include <gtest/gtest.h>

#include <vector>

#include "engine_client/scene/box_scenes.h"
#include "tests/engine_client/broad_phase/backend_under_test.h"

namespace sweepstake {
namespace {

using test_support::MakeOrThrow;

std::vector<OverlapPair> PairsOf(BroadPhase& backend, std::span<const Aabb> boxes) {
  PairBuffer pairs;
  backend.Build(boxes);
  backend.FindPairs(pairs);
  return {pairs.pairs().begin(), pairs.pairs().end()};
}

TEST(Sap, SortsEquallyWithAnyNumberOfThreads) {
  const BoxScene scene("brownian", 60'000, 7);
  const std::vector<OverlapPair> alone = PairsOf(*MakeOrThrow("SAP"), scene.boxes());
  for (const size_t thread_count : {2, 3}) {
    const auto pool = MakeThreadPool(thread_count);
    const auto backend = std::move(*MakeBroadPhase("SAP", {pool.get()}));
    EXPECT_EQ(PairsOf(*backend, scene.boxes()), alone) << thread_count << " threads";
  }
}

// Half of the boxes are spread over a million units, the others lie in a row of a few units.
TEST(Sap, MakesFewChecksIfMostBoxesShareAStep) {
  std::vector<Aabb> boxes(4000);
  for (size_t i = 0; i < boxes.size(); ++i) {
    const float x = i % 2 == 0 ? 500.0F * static_cast<float>(i) : 0.001F * static_cast<float>(i);
    boxes[i] = {{x, 0, 0}, {x + 0.0001F, 1, 1}};
  }
  const auto backend = MakeOrThrow("SAP");
  PairBuffer pairs;
  EXPECT_EQ(test_support::FindPairsError((backend->Build(boxes), *backend), boxes, pairs), "");
  EXPECT_LE(backend->aabb_check_count(), boxes.size() * 200);
}

}  // namespace
}  // namespace sweepstake
