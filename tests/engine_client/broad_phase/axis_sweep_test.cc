// Tests the parts that only AxisSweep has: the kept orders, and the choice between repair and
// sweep.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "engine_client/broad_phase/sweep/sorted_endpoints.h"
#include "engine_client/scene/box_scenes.h"
#include "tests/engine_client/broad_phase/backend_under_test.h"

namespace sweepstake {
namespace {

using test_support::FindPairsError;
using test_support::MakeOrThrow;

Aabb UnitBoxAt(float x) { return {{x, 0, 0}, {x + 1, 1, 1}}; }

std::vector<Aabb> UnitBoxesInARow(size_t count, float distance) {
  std::vector<Aabb> boxes(count);
  for (size_t i = 0; i < count; ++i) boxes[i] = UnitBoxAt(distance * static_cast<float>(i));
  return boxes;
}

std::vector<BoxRecord> RecordsAlongX(std::initializer_list<float> positions) {
  std::vector<BoxRecord> records;
  for (const float x : positions) records.push_back(RecordOf(UnitBoxAt(x)));
  return records;
}

MovedBoxes AllMoved(size_t count) {
  MovedBoxes moved;
  moved.Clear(count);
  for (size_t i = 0; i < count; ++i) moved.Add(i);
  return moved;
}

// Returns the owners and faces in order as a string such as "L0 U0".
std::string OrderOf(const SortedEndpoints& axis) {
  std::string order;
  for (const Endpoint endpoint : axis.endpoints()) {
    order += IsUpperFace(endpoint) ? 'U' : 'L';
    order += std::to_string(EndpointOwner(endpoint));
  }
  return order;
}

class FacesOnAnAxis : public testing::Test {
 protected:
  // Sorts the faces by quantized steps, and then exactly.
  void Sort(std::span<const BoxRecord> records, float low = 0, float high = 10) {
    constexpr float kSteps = 64;
    axis_.Sort(records, {false, low, kSteps / std::max(high - low, 1e-30F), kSteps - 1}, room_);
    SwapAllowance budget(100'000);
    ASSERT_TRUE(
        axis_.Repair(records, AllMoved(records.size()), room_, budget, [](uint32_t, uint32_t) {}));
    ASSERT_TRUE(axis_.is_exact());
  }

  SortedEndpoints axis_{0};
  EndpointRoom room_;
};

TEST_F(FacesOnAnAxis, AreLowerBeforeUpperWhereTheyTouch) {
  Sort(RecordsAlongX({1, 0}));
  EXPECT_EQ(OrderOf(axis_), "L1L0U1U0");
}

TEST_F(FacesOnAnAxis, AreOrderedByStepAfterASort) {
  std::vector<BoxRecord> records;
  SequentialRandom random(4);
  for (int i = 0; i < 300; ++i) records.push_back(RecordOf(UnitBoxAt(random.Between(0, 100))));
  const SweepAxis steps{false, 0, 10, 999};
  axis_.Sort(records, steps, room_);
  EXPECT_FALSE(axis_.is_exact());
  uint32_t before = 0;
  for (const Endpoint face : axis_.endpoints()) {
    const BoxRecord& record = records[EndpointOwner(face)];
    const uint32_t step = steps.Step(IsUpperFace(face) ? record.max[0] : record.min[0]);
    EXPECT_LE(before, step);
    before = step;
  }
}

TEST_F(FacesOnAnAxis, HaveTheSameOrderForAnyRange) {
  std::vector<BoxRecord> records;
  SequentialRandom random(4);
  for (int i = 0; i < 300; ++i) records.push_back(RecordOf(UnitBoxAt(random.Between(-50, 50))));
  records.push_back(kInvalidRecord);
  Sort(records, -50, 50);
  const std::string order = OrderOf(axis_);
  for (const auto& [low, high] : {std::pair{0.0F, 0.0F}, {1e30F, 1e30F}, {-1e38F, 1e38F}}) {
    Sort(records, low, high);
    EXPECT_EQ(OrderOf(axis_), order);
  }
}

TEST_F(FacesOnAnAxis, RepairReportsEachSwapOfALowerAndAnUpperFace) {
  Sort(RecordsAlongX({0, 5}));
  SwapAllowance budget(10);
  std::vector<std::pair<uint32_t, uint32_t>> swaps;
  EXPECT_TRUE(axis_.Repair(RecordsAlongX({5.5F, 5}), AllMoved(2), room_, budget,
                           [&](uint32_t a, uint32_t b) { swaps.emplace_back(a, b); }));
  EXPECT_EQ(OrderOf(axis_), "L1L0U1U0");
  EXPECT_EQ(swaps, (std::vector<std::pair<uint32_t, uint32_t>>{{0, 1}}));
  EXPECT_EQ(budget.left(), 7U);
}

TEST_F(FacesOnAnAxis, AreOrderedAfterARepairOfTheMovedBoxes) {
  SequentialRandom random(9);
  for (int round = 0; round < 50; ++round) {
    std::vector<BoxRecord> records;
    for (int i = 0; i < 40; ++i) records.push_back(RecordOf(UnitBoxAt(random.Between(0, 20))));
    Sort(records);
    MovedBoxes moved;
    moved.Clear(records.size());
    for (int change = 0; change < round % 8; ++change) {
      const size_t i = random.Below(records.size());
      records[i] =
          random.Below(5) == 0 ? kInvalidRecord : RecordOf(UnitBoxAt(random.Between(0, 20)));
      moved.Add(i);
    }
    SwapAllowance budget(10'000);
    EXPECT_TRUE(axis_.Repair(records, moved, room_, budget, [](uint32_t, uint32_t) {}));
    float before = -kInfinity;
    for (const Endpoint endpoint : axis_.endpoints()) {
      const BoxRecord& record = records[EndpointOwner(endpoint)];
      const float at = IsUpperFace(endpoint) ? record.max[0] : record.min[0];
      EXPECT_LE(before, at);
      before = at;
    }
  }
}

TEST_F(FacesOnAnAxis, RepairEndsAtAStopRequest) {
  class StopAtTheSecondQuestion final : public StopRequest {
   public:
    bool WantsStop(uint64_t, uint64_t) noexcept override { return ++question_count >= 2; }
    int question_count = 0;
  };
  constexpr int kCount = 1000;
  std::vector<BoxRecord> records;
  for (int i = 0; i < kCount; ++i) records.push_back(RecordOf(UnitBoxAt(2.0F * float(i))));
  Sort(records, 0, 2.0F * kCount);
  std::reverse(records.begin(), records.end());
  StopAtTheSecondQuestion stop;
  SwapAllowance allowance(10'000'000, &stop);
  EXPECT_FALSE(
      axis_.Repair(records, AllMoved(kCount), room_, allowance, [](uint32_t, uint32_t) {}));
  EXPECT_EQ(stop.question_count, 2);
}

TEST_F(FacesOnAnAxis, RepairEndsWhenTheBudgetIsSpent) {
  Sort(RecordsAlongX({0, 5, 10}), 0, 10);
  const auto records = RecordsAlongX({20, 15, 10});
  SwapAllowance budget(2);
  EXPECT_FALSE(axis_.Repair(records, AllMoved(3), room_, budget, [](uint32_t, uint32_t) {}));
  Sort(records);
  EXPECT_EQ(OrderOf(axis_), "L2U2L1U1L0U0");
}

TEST_F(FacesOnAnAxis, AppendAndTruncateKeepTheOrder) {
  auto records = RecordsAlongX({4, 0, 8});
  Sort(records);
  records.push_back(RecordOf(UnitBoxAt(2)));
  records.push_back(RecordOf(UnitBoxAt(20)));
  axis_.Append(records, 3, room_);
  EXPECT_EQ(OrderOf(axis_), "L1U1L3U3L0U0L2U2L4U4");
  axis_.Truncate(2);
  EXPECT_EQ(OrderOf(axis_), "L1U1L0U0");
}

class AxisSweepOverFrames : public testing::Test {
 protected:
  void Expect(std::span<const Aabb> boxes) {
    backend_->Update(boxes);
    EXPECT_EQ(FindPairsError(*backend_, boxes, pairs_), "");
  }

  std::unique_ptr<BroadPhase> backend_ = MakeOrThrow("AxisSweep");
  PairBuffer pairs_;
};

TEST_F(AxisSweepOverFrames, MakesNoChecksIfNothingMoves) {
  const BoxScene scene("brownian", 500, 1);
  backend_->Build(scene.boxes());
  backend_->FindPairs(pairs_);
  Expect(scene.boxes());  // keeps the pairs of this sweep
  for (int frame = 0; frame < 3; ++frame) {
    Expect(scene.boxes());
    EXPECT_EQ(backend_->aabb_check_count(), 0U);
  }
}

TEST_F(AxisSweepOverFrames, ChecksOnlyThePairThatBeginsToOverlap) {
  std::vector<Aabb> boxes = UnitBoxesInARow(100, 3);
  backend_->Build(boxes);
  backend_->FindPairs(pairs_);
  Expect(boxes);
  boxes[7] = UnitBoxAt(3 * 8 - 1);
  Expect(boxes);
  EXPECT_EQ(pairs_.size(), 1U);
  EXPECT_EQ(backend_->aabb_check_count(), 1U);
  boxes[7] = UnitBoxAt(3 * 8 - 1.5F);
  Expect(boxes);
  EXPECT_EQ(pairs_.size(), 0U);
}

TEST_F(AxisSweepOverFrames, FindsAllPairsThroughRestAndMotion) {
  for (const std::string_view kind :
       {"brownian", "broken-boxes", "signed-zeros", "touching-faces", "zero-size", "mixture"}) {
    BoxScene scene(kind, 400, 17);
    std::vector<Aabb> boxes(scene.boxes().begin(), scene.boxes().end());
    backend_->Build(boxes);
    backend_->FindPairs(pairs_);
    SequentialRandom random(1);
    for (int frame = 0; frame < 80; ++frame) {
      // At first all boxes rest, then one more box per frame moves, then all boxes move.
      const size_t changes = frame % 20 < 5 ? 0 : frame % 20 < 18 ? 1 + frame % 20 : boxes.size();
      if (changes > 0) scene.Step();
      for (size_t change = 0; change < changes; ++change) {
        const size_t i = changes == boxes.size() ? change : random.Below(boxes.size());
        boxes[i] = scene.boxes()[i];
      }
      Expect(boxes);
    }
  }
}

TEST_F(AxisSweepOverFrames, FindsAllPairsWhileTheCountChanges) {
  for (const std::string_view kind : {"nearly-resting", "brownian", "broken-boxes", "long-thin"}) {
    BoxScene scene(kind, 600, 3);
    SequentialRandom random(2);
    backend_->Build(scene.boxes().first(500));
    backend_->FindPairs(pairs_);
    for (int frame = 0; frame < 40; ++frame) {
      scene.Step();
      Expect(scene.boxes().first(480 + random.Below(frame % 5 == 4 ? 120 : 20)));
    }
  }
}

// In each frame 20 boxes jump from one end of the row to the other. A repair would have to move
// them past all other boxes.
TEST_F(AxisSweepOverFrames, SweepsInsteadOfARepairThatCostsMore) {
  std::vector<Aabb> boxes = UnitBoxesInARow(1000, 1.5F);
  backend_->Build(boxes);
  backend_->FindPairs(pairs_);
  for (int frame = 0; frame < 12; ++frame) {
    for (size_t i = 0; i < 20; ++i)
      boxes[i] =
          UnitBoxAt(frame % 2 == 0 ? 2000 + 3 * static_cast<float>(i) : static_cast<float>(i));
    Expect(boxes);
    EXPECT_GT(backend_->aabb_check_count(), 0U);
  }
}

}  // namespace
}  // namespace sweepstake
