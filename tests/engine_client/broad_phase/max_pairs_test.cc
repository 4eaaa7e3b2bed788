// BroadPhaseOptions::max_pairs must end a search whose pairs explode, with bounded memory, and
// without effects on the structure that is built next.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include "engine_client/broad_phase/common/stop_poll.h"
#include "engine_client/broad_phase/host/exceptions.h"
#include "engine_client/scene/box_scenes.h"
#include "engine_client/scene/suite_scene.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/hooks.h"
#include "tests/engine_client/broad_phase/backend_under_test.h"

namespace sweepstake {
namespace {

using test_support::FindPairsError;
using test_support::ScalarPairs;
using test_support::SequenceError;

constexpr size_t kThreads = 2;

// Returns `count` boxes in a row. Every second one is in the place of the box before it, so that
// there are count ÷ 2 pairs.
std::vector<Aabb> BoxesInTwos(size_t count) {
  std::vector<Aabb> boxes(count);
  for (size_t i = 0; i < count; ++i) {
    const float x = 10 * static_cast<float>(i / 2);
    boxes[i] = {{x, 0, 0}, {x + 1, 1, 1}};
  }
  return boxes;
}

class EveryBackendWithMaxPairs : public testing::TestWithParam<std::string_view> {
 protected:
  void Make(uint64_t max_pairs, Executor* executor = nullptr) {
    backend_ =
        std::move(*MakeBroadPhase(GetParam(), {.executor = executor, .max_pairs = max_pairs}));
    pairs_ = PairBuffer();
  }

  std::unique_ptr<BroadPhase> backend_;
  PairBuffer pairs_;
};

TEST_P(EveryBackendWithMaxPairs, EndsASearchWithTooManyPairsWithinBoundedMemory) {
  constexpr uint64_t kMaxPairs = 1'000'000;
  // A tile, a leaf or a list of near leaves is checked without a stop test. A buffer doubles.
  constexpr uint64_t kMaxFound = kMaxPairs + kThreads * 3 * StopPoll::kChecksPerQuestion;
  constexpr uint64_t kMaxBytes = 2 * kMaxFound * sizeof(OverlapPair);
  const auto pool = MakeThreadPool(kThreads);
  const auto dense = MakeDegenerateScene("all-coincident", 20'000, 1);  // 200 million pairs
  const auto next = MakeSuiteBrownian(500);
  for (Executor* const executor : {static_cast<Executor*>(nullptr), pool.get()}) {
    Make(kMaxPairs, executor);
    backend_->Build(dense->aabbs());
    const uint64_t built_bytes = backend_->native_bytes();
    // The buffers are kept between frames, and must not grow with each frame.
    for (int frame = 0; frame < 4; ++frame) {
      backend_->Build(dense->aabbs());
      pairs_.Clear();
      backend_->FindPairs(pairs_);
      EXPECT_TRUE(backend_->pairs_exceeded());
      EXPECT_TRUE(pairs_.empty());
      EXPECT_LE(pairs_.capacity_bytes() + backend_->native_bytes() - built_bytes, kMaxBytes);
    }
    backend_->Build(next->aabbs());
    EXPECT_EQ(FindPairsError(*backend_, next->aabbs(), pairs_), "");
    EXPECT_FALSE(backend_->pairs_exceeded());
    next->Step();
    backend_->Update(next->aabbs());
    EXPECT_EQ(FindPairsError(*backend_, next->aabbs(), pairs_), "");
  }
}

// The scene rests, so that backends with kept pairs copy them without a search.
TEST_P(EveryBackendWithMaxPairs, AllowsExactlyTheMaximum) {
  std::vector<Aabb> boxes = BoxesInTwos(2000);
  Make(1000);
  backend_->Build(boxes);
  for (int frame = 0; frame < 12; ++frame) {
    ASSERT_EQ(FindPairsError(*backend_, boxes, pairs_), "") << "in frame " << frame;
    ASSERT_FALSE(backend_->pairs_exceeded());
    backend_->Update(boxes);
  }
  boxes[1999] = boxes[0];  // one pair ends, and two begin
  backend_->Update(boxes);
  pairs_.Clear();
  pairs_.Append({7, 8});
  backend_->FindPairs(pairs_);
  EXPECT_TRUE(backend_->pairs_exceeded());
  ASSERT_EQ(pairs_.size(), 1U) << "only the caller's own pair stays";
  EXPECT_EQ(pairs_.pairs()[0].a, 7U);
}

TEST_P(EveryBackendWithMaxPairs, FindsTheSameSequenceBelowTheMaximum) {
  const auto scene = MakeSuiteBrownian(3000);
  Make(1'000'000);
  const auto twin = test_support::MakeOrThrow(GetParam());
  backend_->Build(scene->aabbs());
  twin->Build(scene->aabbs());
  for (int frame = 0; frame < 8; ++frame) {
    ASSERT_EQ(SequenceError(*backend_, *twin, pairs_), "") << "in frame " << frame;
    if (frame < 4) scene->Step();  // the scene rests after that
    backend_->Update(scene->aabbs());
    twin->Update(scene->aabbs());
  }
}

INSTANTIATE_TEST_SUITE_P(BroadPhase, EveryBackendWithMaxPairs, testing::ValuesIn(BroadPhaseNames()),
                         [](const auto& name) { return std::string(name.param); });

// Returns `count` cubes in a lattice with gaps. Its lowest corner is `first` on each axis.
std::vector<Aabb> Lattice(size_t count, float first, float spacing, float side) {
  std::vector<Aabb> boxes(count);
  for (size_t i = 0; i < count; ++i) {
    const size_t cell[3] = {i % 64, i / 64 % 64, i / 4096};
    for (size_t axis = 0; axis < 3; ++axis) {
      boxes[i].min[axis] = first + spacing * static_cast<float>(cell[axis]);
      boxes[i].max[axis] = boxes[i].min[axis] + side;
    }
  }
  return boxes;
}

// Backends that keep pairs between frames. Those with margins search for pairs in Update.
class EveryBackendThatKeepsPairs : public EveryBackendWithMaxPairs {};

TEST_P(EveryBackendThatKeepsPairs, KeepsFewPairsIfBoxesMeetWhileTheOthersRest) {
  constexpr size_t kCount = 200'000;
  constexpr uint64_t kMaxPairs = 1'000'000;
  constexpr uint64_t kMaxKept = 24 * kCount + 3 * StopPoll::kChecksPerQuestion;
  std::vector<Aabb> boxes = Lattice(kCount, 0, 4, 1);
  Make(kMaxPairs);
  backend_->Build(boxes);
  for (int frame = 0; frame < 5; ++frame) {
    backend_->FindPairs(pairs_);
    ASSERT_TRUE(pairs_.empty());
    backend_->Update(boxes);
  }
  const uint64_t resting_bytes = backend_->native_bytes();
  std::fill_n(boxes.begin(), 6000, boxes[0]);  // 18 million pairs
  backend_->Update(boxes);
  backend_->FindPairs(pairs_);
  EXPECT_TRUE(backend_->pairs_exceeded());
  EXPECT_LE(pairs_.capacity_bytes() + backend_->native_bytes() - resting_bytes,
            2 * (kMaxPairs + kMaxKept) * sizeof(OverlapPair));
}

// Most boxes are large, so that their margins are wider than the gaps between the small boxes.
TEST_P(EveryBackendThatKeepsPairs, KeepsFewPairsIfOnlyMarginsOverlap) {
  constexpr uint64_t kMaxKept = 24 * 20'000 + 3 * StopPoll::kChecksPerQuestion;
  std::vector<Aabb> boxes = Lattice(20'000, 0, 4, 1);
  const std::vector<Aabb> dust = Lattice(8'000, 2, 1e-4F, 1e-5F);
  std::copy(dust.begin(), dust.end(), boxes.begin());
  Make(1000);
  backend_->Build(boxes);
  const uint64_t built_bytes = backend_->native_bytes();
  for (int frame = 0; frame < 5; ++frame) {
    backend_->FindPairs(pairs_);
    ASSERT_FALSE(backend_->pairs_exceeded());
    backend_->Update(boxes);
    EXPECT_LE(backend_->native_bytes() - built_bytes, 2 * kMaxKept * sizeof(OverlapPair));
  }
}

INSTANTIATE_TEST_SUITE_P(BroadPhase, EveryBackendThatKeepsPairs,
                         testing::Values("AxisSweep", "DBVT", "Tracy"),
                         [](const auto& name) { return std::string(name.param); });

class CountedStop final : public StopRequest {
 public:
  bool WantsStop(uint64_t, uint64_t) noexcept override {
    ++question_count;
    return wants_stop;
  }

  bool wants_stop = false;
  uint64_t question_count = 0;
};

TEST(MaxPairs, AStopRequestStillEndsTheSearch) {
  const auto backend = std::move(*MakeBroadPhase("Grid", {.max_pairs = 1'000'000'000}));
  const auto dense = MakeDegenerateScene("all-coincident", 5'000, 1);
  backend->Build(dense->aabbs());
  CountedStop stop;
  stop.wants_stop = true;
  backend->SetStop(&stop);
  PairBuffer pairs;
  backend->FindPairs(pairs);
  EXPECT_LT(pairs.size(), ScalarPairs(dense->aabbs()).size());
  EXPECT_FALSE(backend->pairs_exceeded());
}

// A request that ignores the end of a part is not polled then.
TEST(MaxPairs, PassesTheEndOfASearchToTheStopRequest) {
  class EndStop final : public StopRequest {
   public:
    bool WantsStop(uint64_t, uint64_t pairs) noexcept override {
      found_pairs += pairs;
      return false;
    }
    void OnEnd(uint64_t, uint64_t pairs) noexcept override {
      found_pairs += pairs;
      ++end_count;
    }
    uint64_t found_pairs = 0;
    int end_count = 0;
  };
  const auto backend = std::move(*MakeBroadPhase("BruteForce", {.max_pairs = 1'000'000'000}));
  const auto dense = MakeDegenerateScene("all-coincident", 100, 1);
  backend->Build(dense->aabbs());
  EndStop stop;
  backend->SetStop(&stop);
  PairBuffer pairs;
  backend->FindPairs(pairs);
  EXPECT_EQ(stop.found_pairs, pairs.size());
  EXPECT_GE(stop.end_count, 1);
}

#if SWEEPSTAKE_HAS_EXCEPTIONS
bool memory_is_left = true;

// During a search the limit is the backend's stop request. The request must be the caller's again
// afterwards, even if the search throws.
TEST(MaxPairs, RestoresTheStopRequestIfMemoryRunsOut) {
  memory_is_left = true;
  Hooks hooks;
  hooks.allocate = [](size_t bytes, size_t alignment, void*) -> void* {
    if (!memory_is_left) return nullptr;
    return ::operator new(bytes, std::align_val_t(alignment));
  };
  hooks.release = [](void* pointer, size_t, size_t alignment, void*) {
    ::operator delete(pointer, std::align_val_t(alignment));
  };
  ASSERT_TRUE(SetHooks(hooks).ok());
  {
    const auto boxes = BoxesInTwos(1000);
    const auto backend = std::move(*MakeBroadPhase("BruteForce", {.max_pairs = 1'000'000}));
    CountedStop stop;
    backend->SetStop(&stop);
    backend->Build(boxes);
    PairBuffer pairs;
    memory_is_left = false;
    EXPECT_THROW(backend->FindPairs(pairs), std::bad_alloc);
    memory_is_left = true;
    stop.question_count = 0;
    backend->Build(boxes);
    EXPECT_GT(stop.question_count, 0U);
    backend->FindPairs(pairs);
    EXPECT_EQ(pairs.size(), 500U);
  }
  ASSERT_TRUE(SetHooks({}).ok());
}
#endif

}  // namespace
}  // namespace sweepstake
