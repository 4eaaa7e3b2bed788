// Tests the costs of a frame other than time: no allocation in steady state, no cost of boxes that
// have gone, and correct counts of bytes and checks.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <tuple>
#include <vector>

#include "engine_client/scene/box_scenes.h"
#include "engine_client/scene/random.h"
#include "tests/engine_client/broad_phase/backend_under_test.h"
#include "tests/support/allocation_counter.h"

namespace sweepstake {
namespace {

using test_support::MakeOrThrow;
using test_support::SequenceError;
using test_support::ThreadAllocationCount;

constexpr std::string_view kSteadyScenes[] = {"brownian",     "nearly-resting", "all-coincident",
                                              "all-disjoint", "one-huge",       "broken-boxes",
                                              "teleporting",  "sizes-1-to-1000"};

class SteadyState : public testing::TestWithParam<std::tuple<std::string_view, std::string_view>> {
 protected:
  void RunFrames(int count) {
    for (int frame = 0; frame < count; ++frame) {
      scene_.Step();
      pairs_.Clear();
      backend_->Update(scene_.boxes());
      backend_->FindPairs(pairs_);
    }
  }

  std::unique_ptr<BroadPhase> backend_ = MakeOrThrow(std::get<0>(GetParam()));
  BoxScene scene_{std::get<1>(GetParam()), 800, 21};
  PairBuffer pairs_;
};

TEST_P(SteadyState, AllocatesNothingAndKeepsTheMemorySize) {
  backend_->Build(scene_.boxes());
  RunFrames(100);
  const uint64_t allocations = ThreadAllocationCount();
  const size_t bytes = backend_->native_bytes();
  const size_t pair_bytes = pairs_.capacity_bytes();
  RunFrames(100);
  EXPECT_EQ(ThreadAllocationCount(), allocations);
  EXPECT_EQ(backend_->native_bytes(), bytes);
  EXPECT_EQ(pairs_.capacity_bytes(), pair_bytes);
}

TEST_P(SteadyState, AnotherBuildReusesTheMemory) {
  for (int round = 0; round < 20; ++round) {
    backend_->Build(scene_.boxes());
    RunFrames(5);
  }
  const uint64_t allocations = ThreadAllocationCount();
  backend_->Build(scene_.boxes());
  RunFrames(5);
  EXPECT_EQ(ThreadAllocationCount(), allocations);
}

INSTANTIATE_TEST_SUITE_P(, SteadyState,
                         testing::Combine(testing::ValuesIn(BroadPhaseNames().begin(),
                                                            BroadPhaseNames().end()),
                                          testing::ValuesIn(kSteadyScenes)),
                         [](const auto& test) {
                           std::string name(std::get<0>(test.param));
                           name += '_';
                           name += std::get<1>(test.param);
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

// Boxes that come all at once and go soon.
struct Burst {
  std::string_view name;
  size_t count;
  float side;      // they are in the cube from 0 to this
  float box_side;  // their length
};

void PrintTo(const Burst& burst, std::ostream* out) { *out << burst.name; }

constexpr Burst kBursts[] = {{"AFewMore", 400, 40, 1},
                             {"FarAround", 8000, 400, 1},
                             {"VeryFarAround", 4000, 10'000, 1},
                             {"InOnePlace", 1000, 2, 1},
                             {"OfLargeBoxes", 1000, 40, 8}};

class AfterABurst : public testing::TestWithParam<std::tuple<std::string_view, Burst>> {
 protected:
  static constexpr size_t kLiving = 1000;
  static constexpr float kLivingSide = 32;
  // The minimum number of frames from one start to the next (broad_phase.h).
  static constexpr int kFramesPerStart = 32;

  AfterABurst() {
    const Burst& burst = std::get<1>(GetParam());
    for (size_t k = 0; k < kLiving; ++k) AddBox(kLivingSide, 1);
    for (size_t k = 0; k < burst.count; ++k) AddBox(burst.side, burst.box_side);
  }

  // Moves the living boxes a little and returns the boxes of the next frame.
  std::span<const Aabb> NextBoxes(size_t count) {
    for (size_t k = 0; k < kLiving; ++k) {
      const float along = random_.Between(-0.02F, 0.02F);
      boxes_[k].min[k % 3] += along;
      boxes_[k].max[k % 3] += along;
    }
    return std::span(boxes_).first(count);
  }
  void RunFrames(int frames, size_t count) {
    for (int frame = 0; frame < frames; ++frame) {
      backend_->Update(NextBoxes(count));
      pairs_.Clear();
      backend_->FindPairs(pairs_);
    }
  }
  // From the next frame on, expects the pairs, their order and the checks of a backend that is
  // built in that frame.
  void ExpectAStart() {
    const auto fresh = MakeOrThrow(std::get<0>(GetParam()));
    for (int frame = 0; frame < 80; ++frame) {
      const std::span<const Aabb> living = NextBoxes(kLiving);
      backend_->Update(living);
      frame == 0 ? fresh->Build(living) : fresh->Update(living);
      ASSERT_EQ(SequenceError(*backend_, *fresh, pairs_), "") << frame;
    }
  }

  std::unique_ptr<BroadPhase> backend_ = MakeOrThrow(std::get<0>(GetParam()));
  std::vector<Aabb> boxes_;
  PairBuffer pairs_;

 private:
  void AddBox(float side, float box_side) {
    Aabb box;
    for (int axis = 0; axis < 3; ++axis) {
      box.min[axis] = random_.Between(0, side);
      box.max[axis] = box.min[axis] + box_side;
    }
    boxes_.push_back(box);
  }

  SequentialRandom random_{5};
};

TEST_P(AfterABurst, ABackendStartsAgain) {
  backend_->Build(NextBoxes(kLiving));
  RunFrames(kFramesPerStart, kLiving);
  RunFrames(70, boxes_.size());
  ExpectAStart();
}

TEST_P(AfterABurst, ABackendStartsAgainAtMostEvery32Frames) {
  backend_->Build(NextBoxes(kLiving));
  RunFrames(3, boxes_.size());
  RunFrames(kFramesPerStart - 4, kLiving);
  ExpectAStart();
}

// The frames in which some boxes go also count.
TEST_P(AfterABurst, ABackendStartsAgainIfTheBoxesGoOneByOne) {
  backend_->Build(NextBoxes(boxes_.size()));
  for (int frame = 1; frame < kFramesPerStart; ++frame)
    RunFrames(1, boxes_.size() - (boxes_.size() - kLiving) * frame / kFramesPerStart);
  ExpectAStart();
}

INSTANTIATE_TEST_SUITE_P(
    , AfterABurst,
    testing::Combine(testing::ValuesIn(BroadPhaseNames().begin(), BroadPhaseNames().end()),
                     testing::ValuesIn(kBursts)),
    [](const auto& test) {
      return std::string(std::get<0>(test.param)).append("_").append(std::get<1>(test.param).name);
    });

class MemoryOf : public testing::TestWithParam<std::string_view> {};

// A box has 24 bytes: a backend that reports fewer bytes than the boxes have does not count all of
// its memory.
TEST_P(MemoryOf, IsAtLeastTheBoxesAndBounded) {
  const auto backend = MakeOrThrow(GetParam());
  BoxScene scene("brownian", 3000, 2);
  PairBuffer pairs;
  backend->Build(scene.boxes());
  backend->FindPairs(pairs);
  EXPECT_GE(backend->native_bytes(), 3000 * sizeof(Aabb));
  EXPECT_LE(backend->native_bytes(), 3000U * 1000);
}

INSTANTIATE_TEST_SUITE_P(EveryBackend, MemoryOf,
                         testing::ValuesIn(BroadPhaseNames().begin(), BroadPhaseNames().end()),
                         [](const auto& test) { return std::string(test.param); });

TEST(AllocationCounter, CountsEveryFormOfNew) {
  const uint64_t before = ThreadAllocationCount();
  const auto one = std::make_unique<int>(1);
  const auto many = std::make_unique<int[]>(10);
  struct alignas(64) Line {
    char bytes[64];
  };
  const auto aligned = std::make_unique<Line>();
  EXPECT_EQ(ThreadAllocationCount(), before + 3);
}

struct Counted {
  uint64_t checks;
  uint64_t pairs;
};

Counted CountChecks(std::string_view name, BoxScene& scene, int updates) {
  const auto backend = MakeOrThrow(name);
  PairBuffer pairs;
  backend->Build(scene.boxes());
  backend->FindPairs(pairs);
  for (int frame = 0; frame < updates; ++frame) {
    scene.Step();
    pairs.Clear();
    backend->Update(scene.boxes());
    backend->FindPairs(pairs);
  }
  return {backend->aabb_check_count(), pairs.size()};
}

// Four boxes are tested together against registers of partners. A group may therefore test up to
// one register and three boxes more than needed.
constexpr uint64_t kWidestRegister = 64;
uint64_t AllPairChecks(uint64_t count) {
  return count * (count - 1) / 2 + (count + 3) * (kWidestRegister + 3);
}

TEST(CheckCountOfBruteForce, IsHalfTheSquareOfTheCount) {
  for (const uint64_t count : {2, 10, 100, 1000}) {
    BoxScene scene("brownian", count, 4);
    const Counted counted = CountChecks("BruteForce", scene, 1);
    EXPECT_GE(counted.checks, count * (count - 1) / 2);
    EXPECT_LE(counted.checks, AllPairChecks(count));
  }
}

TEST(CheckCountOfSap, IsBetweenThePairsAndAllPairs) {
  BoxScene scene("brownian", 3000, 4);
  const Counted counted = CountChecks("SAP", scene, 1);
  EXPECT_GE(counted.checks, counted.pairs);
  EXPECT_LE(counted.checks, AllPairChecks(3000) / 3)
      << "boxes far away on the sweep axis are skipped";
  BoxScene coincident("all-coincident", 500, 4);
  EXPECT_LE(CountChecks("SAP", coincident, 1).checks, AllPairChecks(500));
}

TEST(CheckCountOfAxisSweep, FollowsMotion) {
  BoxScene moving("brownian", 3000, 4);
  BoxScene resting("nearly-resting", 3000, 4);
  const Counted much = CountChecks("AxisSweep", moving, 10);
  const Counted little = CountChecks("AxisSweep", resting, 10);
  EXPECT_GE(much.checks, much.pairs);
  EXPECT_GT(little.checks, 0U);
  EXPECT_LE(little.checks, 3000U);
}

}  // namespace
}  // namespace sweepstake
