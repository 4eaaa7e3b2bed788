// What is AxisSweep's own: the kept orders, and the two ways between which it chooses.
#include <gtest/gtest.h>

#include <vector>

#include "engine_client/broad_phase/sorted_endpoints.h"
#include "engine_client/broad_phase/sweep_axis.h"
#include "tests/engine_client/broad_phase/backend_under_test.h"
#include "tests/support/box_scenes.h"

namespace sweepstake {
namespace {

using test_support::BoxScene;
using test_support::MakeOrThrow;
using test_support::Verdict;

Aabb UnitBoxAt(float x) { return {{x, 0, 0}, {x + 1, 1, 1}}; }

std::vector<Aabb> UnitBoxesInARow(size_t count, float distance) {
  std::vector<Aabb> boxes(count);
  for (size_t i = 0; i < count; ++i) boxes[i] = UnitBoxAt(distance * static_cast<float>(i));
  return boxes;
}

std::vector<BoxKeys> KeysAlongX(std::initializer_list<float> positions) {
  std::vector<BoxKeys> keys;
  for (const float x : positions) {
    keys.push_back({{SortableKey(x), SortableKey(0), SortableKey(0), SortableKey(x + 1),
                     SortableKey(1), SortableKey(1)}});
  }
  return keys;
}

// "L0 U0" as a string: the owners and faces in order.
std::string OrderOf(const SortedEndpoints& axis) {
  std::string order;
  for (const uint64_t endpoint : axis.endpoints()) {
    order += IsUpperFace(endpoint) ? 'U' : 'L';
    order += std::to_string(EndpointOwner(endpoint));
  }
  return order;
}

TEST(SortedEndpoints, PutLowerFacesBeforeUpperOnesThatTouchThem) {
  SortedEndpoints axis;
  RadixSort sort;
  axis.Reset(2);
  axis.Refresh(KeysAlongX({1, 0}), 0);
  axis.Resort(sort);
  EXPECT_EQ(OrderOf(axis), "L1L0U1U0");
}

TEST(SortedEndpoints, RepairReportsEachPassingOnce) {
  SortedEndpoints axis;
  RadixSort sort;
  axis.Reset(2);
  axis.Refresh(KeysAlongX({0, 5}), 0);
  axis.Resort(sort);
  EXPECT_EQ(axis.Refresh(KeysAlongX({5.5F, 5}), 0), 1U);
  size_t budget = 10;
  std::vector<std::pair<uint32_t, uint32_t>> passings;
  EXPECT_TRUE(axis.Repair(budget, [&](uint64_t stayed, uint64_t moved) {
    passings.emplace_back(EndpointOwner(stayed), EndpointOwner(moved));
  }));
  EXPECT_EQ(OrderOf(axis), "L1L0U1U0");
  EXPECT_EQ(passings, (std::vector<std::pair<uint32_t, uint32_t>>{{0, 1}, {0, 1}, {0, 1}}));
  EXPECT_EQ(budget, 7U);
}

TEST(SortedEndpoints, RepairStopsWhenTheBudgetIsSpent) {
  SortedEndpoints axis;
  RadixSort sort;
  axis.Reset(3);
  axis.Refresh(KeysAlongX({0, 5, 10}), 0);
  axis.Resort(sort);
  axis.Refresh(KeysAlongX({20, 15, 10}), 0);
  size_t budget = 2;
  EXPECT_FALSE(axis.Repair(budget, [](uint64_t, uint64_t) {}));
  axis.Resort(sort);
  EXPECT_EQ(OrderOf(axis), "L2U2L1U1L0U0");
}

TEST(SweepAxis, IsTheOneWithTheLargestSpread) {
  for (int wide = 0; wide < 3; ++wide) {
    std::vector<Aabb> boxes(10);
    for (size_t i = 0; i < boxes.size(); ++i)
      boxes[i].min[wide] = boxes[i].max[wide] = static_cast<float>(i);
    EXPECT_EQ(AxisOfLargestSpread(boxes), wide);
    boxes.push_back({{1e30F, 1e30F, 1e30F}, {-1e30F, 0, 0}});  // inverted: takes no part
    EXPECT_EQ(AxisOfLargestSpread(boxes), wide);
  }
}

TEST(SweepAxis, IsDefinedForNoBoxesAndForTheLargestFloats) {
  EXPECT_EQ(AxisOfLargestSpread({}), 0);
  const Aabb boxes[] = {{{0, -3e38F, 0}, {0, -3e38F, 0}}, {{0, 3e38F, 0}, {0, 3e38F, 0}}};
  EXPECT_EQ(AxisOfLargestSpread(boxes), 1);
}

class AxisSweepOverFrames : public testing::Test {
 protected:
  void Expect(std::span<const Aabb> boxes) {
    backend_->Update(boxes);
    EXPECT_EQ(Verdict(*backend_, boxes, pairs_), "");
  }

  std::unique_ptr<BroadPhase> backend_ = MakeOrThrow("AxisSweep");
  PairBuffer pairs_;
};

TEST_F(AxisSweepOverFrames, MakesNoCheckWhileNothingMoves) {
  const BoxScene scene("brownian", 500, 1);
  backend_->Build(scene.boxes());
  backend_->FindPairs(pairs_);
  Expect(scene.boxes());  // adopts the pairs of its sweep
  for (int frame = 0; frame < 3; ++frame) {
    Expect(scene.boxes());
    EXPECT_EQ(backend_->aabb_check_count(), 0U);
  }
}

TEST_F(AxisSweepOverFrames, ChecksOnlyThePairThatMeets) {
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

TEST_F(AxisSweepOverFrames, IsRightThroughRestJumpsAndRest) {
  for (const std::string_view kind :
       {"brownian", "broken-boxes", "signed-zeros", "touching-faces", "zero-size", "mixture"}) {
    BoxScene scene(kind, 400, 17);
    std::vector<Aabb> boxes(scene.boxes().begin(), scene.boxes().end());
    backend_->Build(boxes);
    backend_->FindPairs(pairs_);
    test_support::Random random(1);
    for (int frame = 0; frame < 80; ++frame) {
      // Rest, then one more box a frame takes its next state, then all of them.
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

// A repair would have to pass one box through all others each frame.
TEST_F(AxisSweepOverFrames, GivesUpARepairThatCostsMoreThanASweep) {
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
