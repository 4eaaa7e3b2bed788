// A StopRequest must end calls soon, in every scene, with bounded memory, and without effects on
// the structure that is built next. Work is counted in checks, which are the same on every machine.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "engine_client/broad_phase/common/box_record.h"
#include "engine_client/broad_phase/common/stop_poll.h"
#include "engine_client/scene/box_scenes.h"
#include "engine_client/scene/suite_scene.h"
#include "sweepstake/broad_phase.h"
#include "tests/engine_client/broad_phase/backend_under_test.h"

namespace sweepstake {
namespace {

using test_support::FindPairsError;
using test_support::MakeOrThrow;
using test_support::SequenceError;

// Stops at a given check, or if more memory has been used than allowed.
class ScriptedStop final : public StopRequest {
 public:
  bool WantsStop(uint64_t bytes, uint64_t pairs) noexcept override {
    ++question_count;
    grown_bytes += bytes;
    found_pairs += pairs;
    has_stopped |= question_count >= stop_at || grown_bytes > max_bytes;
    return has_stopped;
  }

  uint64_t stop_at = std::numeric_limits<uint64_t>::max();
  uint64_t max_bytes = std::numeric_limits<uint64_t>::max();
  uint64_t question_count = 0;
  uint64_t grown_bytes = 0;
  uint64_t found_pairs = 0;
  bool has_stopped = false;
};

// Divides the work as for two threads, but runs it on one, as the shadow lane does.
class PartsInARow final : public Executor {
 public:
  size_t thread_count() const noexcept override { return 2; }
  void RunParts(size_t part_count, RunPart run_part, void* context) noexcept override {
    for (size_t part = 0; part < part_count; ++part) run_part(context, part);
  }
};

// Upper limit of the checks between two stop tests. A tile, a leaf or a list of near leaves is
// checked without a stop test.
constexpr uint64_t kMaxChecksBetween = 3 * StopPoll::kChecksPerQuestion;
// Upper limit of the stop tests that a call still makes after the stop.
constexpr uint64_t kQuestionsToLeave = 8;

class EveryBackendThatIsStopped : public testing::TestWithParam<std::string_view> {
 protected:
  // Builds without a stop request, and then attaches `stop_`.
  void BuildAndWatch(std::span<const Aabb> boxes) {
    backend_->Build(boxes);
    backend_->SetStop(&stop_);
  }

  std::unique_ptr<BroadPhase> backend_ = MakeOrThrow(GetParam());
  ScriptedStop stop_;
  PairBuffer pairs_;
};

TEST_P(EveryBackendThatIsStopped, EndsASearchAmongManyBoxesWithinFewChecks) {
  const auto scene = MakeSuiteBrownian(100'000);
  stop_.stop_at = 1;
  BuildAndWatch(scene->aabbs());
  backend_->FindPairs(pairs_);
  EXPECT_TRUE(stop_.has_stopped);
  EXPECT_LE(backend_->aabb_check_count(), kMaxChecksBetween);
}

TEST_P(EveryBackendThatIsStopped, EndsASearchInADenseSceneWithinFewChecks) {
  const auto scene = MakeDegenerateScene("all-coincident", 30'000, 1);
  for (const uint64_t stop_at : {1U, 5U}) {
    stop_.stop_at = stop_at;
    stop_.question_count = 0;
    stop_.has_stopped = false;
    BuildAndWatch(scene->aabbs());
    pairs_.Clear();
    backend_->FindPairs(pairs_);
    EXPECT_TRUE(stop_.has_stopped);
    EXPECT_LE(backend_->aabb_check_count(), stop_at * kMaxChecksBetween);
    EXPECT_LE(pairs_.size(), stop_at * kMaxChecksBetween);
    backend_->SetStop(nullptr);
  }
}

TEST_P(EveryBackendThatIsStopped, LimitsTheMemoryOfPairs) {
  PartsInARow parts;
  const auto scene = MakeDegenerateScene("all-coincident", 30'000, 1);
  for (Executor* const executor :
       {static_cast<Executor*>(nullptr), static_cast<Executor*>(&parts)}) {
    backend_ = std::move(*MakeBroadPhase(GetParam(), {.executor = executor}));
    stop_ = ScriptedStop();
    stop_.max_bytes = uint64_t{16} << 20;
    pairs_ = PairBuffer();
    BuildAndWatch(scene->aabbs());
    const uint64_t built_bytes = backend_->native_bytes();
    backend_->FindPairs(pairs_);
    EXPECT_TRUE(stop_.has_stopped);
    // A buffer may have doubled when it exceeded the limit, and then grows by the pairs found
    // before the next stop test.
    EXPECT_LE(pairs_.capacity_bytes() + backend_->native_bytes() - built_bytes,
              2 * stop_.max_bytes + kMaxChecksBetween * sizeof(OverlapPair));
  }
}

TEST_P(EveryBackendThatIsStopped, FindsAllPairsAfterTheNextBuild) {
  const auto dense = MakeDegenerateScene("all-coincident", 2'500, 1);
  const auto next = MakeSuiteBrownian(500);
  bool has_ended = false;
  for (uint64_t stop_at = 1; !has_ended; ++stop_at) {
    stop_ = ScriptedStop();
    stop_.stop_at = stop_at;
    backend_->SetStop(&stop_);
    backend_->Build(dense->aabbs());
    for (int frame = 0; frame < 3 && !stop_.has_stopped; ++frame) {
      pairs_.Clear();
      backend_->FindPairs(pairs_);
      if (!stop_.has_stopped) backend_->Update(dense->aabbs());
    }
    has_ended = !stop_.has_stopped;
    backend_->SetStop(nullptr);
    backend_->Build(next->aabbs());
    ASSERT_EQ(FindPairsError(*backend_, next->aabbs(), pairs_), "") << "stopped at " << stop_at;
    backend_->Update(next->aabbs());
    ASSERT_EQ(FindPairsError(*backend_, next->aabbs(), pairs_), "") << "stopped at " << stop_at;
  }
}

TEST_P(EveryBackendThatIsStopped, FindsTheSameSequenceWithoutAStop) {
  const auto twin = MakeOrThrow(GetParam());
  const auto scene = MakeSuiteBrownian(20'000);
  backend_->SetStop(&stop_);
  backend_->Build(scene->aabbs());
  twin->Build(scene->aabbs());
  for (int frame = 0; frame < 8; ++frame) {
    ASSERT_EQ(SequenceError(*backend_, *twin, pairs_), "") << "in frame " << frame;
    // Later updates may search for pairs of enlarged boxes.
    if (frame == 0) {
      EXPECT_EQ(stop_.found_pairs, pairs_.size());
    }
    if (frame < 4) scene->Step();  // the scene rests after that
    backend_->Update(scene->aabbs());
    twin->Update(scene->aabbs());
  }
  EXPECT_GT(stop_.question_count, 0U);
}

INSTANTIATE_TEST_SUITE_P(BroadPhase, EveryBackendThatIsStopped,
                         testing::ValuesIn(BroadPhaseNames()),
                         [](const auto& name) { return std::string(name.param); });

// A scene of kBlocks blocks is loaded and sorted in blocks, with a stop test between them.
constexpr size_t kBlocks = 5;
constexpr size_t kManyBoxes = kBlocks * kBoxesPerQuestion;

TEST_P(EveryBackendThatIsStopped, EndsABuildAtAnyStopTest) {
  const auto many = MakeSuiteBrownian(kManyBoxes);
  const auto next = MakeSuiteBrownian(500);
  bool has_ended = false;
  for (uint64_t stop_at = 1; !has_ended; stop_at += 1 + stop_at / 4) {
    stop_ = ScriptedStop();
    stop_.stop_at = stop_at;
    backend_->SetStop(&stop_);
    backend_->Build(many->aabbs());
    has_ended = !stop_.has_stopped;
    EXPECT_TRUE(has_ended || stop_.question_count <= stop_at + kQuestionsToLeave);
    backend_->SetStop(nullptr);
    backend_->Build(next->aabbs());
    ASSERT_EQ(FindPairsError(*backend_, next->aabbs(), pairs_), "") << "stopped at " << stop_at;
  }
}

// The number of passes of a backend over all boxes or faces, each with a stop test per block.
struct Passes {
  std::string_view backend;
  uint64_t in_build;
  uint64_t in_update;         // with a new position of every box
  uint64_t with_equal_boxes;  // in Build
};

class EveryBackendInBlocks : public testing::TestWithParam<Passes> {};

TEST_P(EveryBackendInBlocks, TestsForAStopInEachPassOverTheBoxes) {
  const auto scene = MakeSuiteBrownian(kManyBoxes);
  std::vector<Aabb> boxes(scene->aabbs().begin(), scene->aabbs().end());
  const auto backend = MakeOrThrow(GetParam().backend);
  ScriptedStop stop;
  backend->SetStop(&stop);
  backend->Build(boxes);
  EXPECT_GE(stop.question_count, GetParam().in_build * kBlocks);
  stop.question_count = 0;
  std::reverse(boxes.begin(), boxes.end());
  backend->Update(boxes);
  EXPECT_GE(stop.question_count, GetParam().in_update * kBlocks);
  stop.question_count = 0;
  backend->Build(std::vector<Aabb>(kManyBoxes, boxes[0]));
  EXPECT_GE(stop.question_count, GetParam().with_equal_boxes * kBlocks);
}

// The passes: Grid measures, counts, places and gathers. SAP counts, places and fills. AxisSweep
// loads, makes two passes for each axis, and fills. Tracy measures, finds rows, places and sorts.
// Trees gather twice. Equal boxes are sorted exactly: SAP then counts, loads, counts digits and
// fills. AxisSweep counts and loads on each axis, and counts the digits of two faces per box.
INSTANTIATE_TEST_SUITE_P(BroadPhase, EveryBackendInBlocks,
                         testing::Values(Passes{"BruteForce", 1, 1, 1}, Passes{"Grid", 4, 4, 4},
                                         Passes{"SAP", 3, 3, 4}, Passes{"AxisSweep", 8, 8, 14},
                                         Passes{"Tracy", 4, 3, 3}, Passes{"KDTree", 2, 1, 2}),
                         [](const auto& tested) { return std::string(tested.param.backend); });

TEST(ADbvtThatIsStopped, TestsForAStopWhileInsertingManyBoxes) {
  constexpr size_t kReturning = 20'000;
  const auto scene = MakeSuiteBrownian(3 * kReturning);
  std::vector<Aabb> boxes(scene->aabbs().begin(), scene->aabbs().end());
  std::fill_n(boxes.begin(), kReturning, kInvalidAabb);
  const auto backend = MakeOrThrow("DBVT");
  backend->Build(boxes);
  ScriptedStop stop;
  stop.stop_at = 8;
  backend->SetStop(&stop);
  backend->Update(scene->aabbs());
  EXPECT_TRUE(stop.has_stopped) << "there are about ten blocks, each with a stop test";
  EXPECT_LE(stop.question_count, stop.stop_at + kQuestionsToLeave);
}

// Backends with margins search for pairs of enlarged boxes in Update.
class EveryBackendWithMargins : public EveryBackendThatIsStopped {};

TEST_P(EveryBackendWithMargins, TestsForAStopInTheUpdateThatMakesMargins) {
  const auto scene = MakeSuiteBrownian(100'000);
  backend_->Build(scene->aabbs());
  for (int frame = 0; frame < 6; ++frame) {
    pairs_.Clear();
    backend_->FindPairs(pairs_);
    backend_->SetStop(&stop_);
    backend_->Update(scene->aabbs());
    backend_->SetStop(nullptr);
  }
  EXPECT_GT(stop_.question_count, 5U);
}

INSTANTIATE_TEST_SUITE_P(BroadPhase, EveryBackendWithMargins, testing::Values("DBVT", "Tracy"),
                         [](const auto& name) { return std::string(name.param); });

}  // namespace
}  // namespace sweepstake
