// Tests each rule of ODE by which two geoms are near. The calls of dSpaceCollide with a simple
// space are the reference.
#include "sweepstake/ode.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <ode/ode.h>

#include <algorithm>
#include <deque>
#include <limits>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/allocation_counter.h"
#include "tests/support/float_modes.h"
#include "tests/support/one_arm.h"

namespace sweepstake::test_support {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

using Pairs = std::vector<std::pair<dGeomID, dGeomID>>;

void Append(void* pairs, dGeomID a, dGeomID b) { static_cast<Pairs*>(pairs)->emplace_back(a, b); }

class OdeBroadPhaseTest : public ::testing::TestWithParam<std::string_view> {
 protected:
  OdeBroadPhaseTest() {
    dInitODE2(0);
    dAllocateODEDataForThread(dAllocateMaskAll);
    space_ = dSimpleSpaceCreate(nullptr);
    world_ = dWorldCreate();
    broad_phase_ = std::make_unique<OdeBroadPhase>(*search_, space_);
  }
  ~OdeBroadPhaseTest() override {
    dSpaceDestroy(space_);
    dWorldDestroy(world_);
    dCloseODE();
  }

  // Returns a cube with edges of 1 whose centre is on the x axis.
  dGeomID Cube(dReal x, dSpaceID space = nullptr) {
    const dGeomID geom = dCreateBox(space == nullptr ? space_ : space, 1, 1, 1);
    dGeomSetPosition(geom, x, 0, 0);
    return geom;
  }

  void Collide(Pairs& pairs) {
    search_->BeginFrame();
    broad_phase_->Collide(&pairs, Append);
    search_->EndFrame({});
  }

  // Returns the pairs of our broad phase, and expects that ODE has the same in the same order.
  Pairs Found() {
    Pairs ours;
    Pairs theirs;
    Collide(ours);
    dSpaceCollide(space_, &theirs, Append);
    EXPECT_EQ(ours, theirs);
    return ours;
  }

  std::unique_ptr<AdaptiveBroadPhase> search_ =
      std::move(*AdaptiveBroadPhase::Create(OneArm(GetParam(), nullptr, kMaxPairs), nullptr));
  dSpaceID space_;
  dWorldID world_;
  std::unique_ptr<OdeBroadPhase> broad_phase_;
};

INSTANTIATE_TEST_SUITE_P(Each, OdeBroadPhaseTest, ::testing::ValuesIn(BroadPhaseNames()),
                         [](const auto& arm) { return std::string(arm.param); });

TEST_P(OdeBroadPhaseTest, FindsNothingInAnEmptySpace) {
  EXPECT_THAT(Found(), IsEmpty());
  dGeomDestroy(Cube(0));
  EXPECT_THAT(Found(), IsEmpty());
}

TEST_P(OdeBroadPhaseTest, GeomsWhoseFacesTouchAreNear) {
  const dGeomID a = Cube(0);
  const dGeomID b = Cube(1);
  EXPECT_EQ(Found(), Pairs({{b, a}}));
  dGeomSetPosition(b, 1.01, 0, 0);
  EXPECT_THAT(Found(), IsEmpty());
}

// The gap is far below the resolution of float.
TEST_P(OdeBroadPhaseTest, ComparesBoxesInThePrecisionOfOde) {
  if (sizeof(dReal) == sizeof(float)) GTEST_SKIP() << "ODE in single precision";
  Cube(1000);
  const dGeomID b = Cube(1001 + dReal{1e-10});
  EXPECT_THAT(Found(), IsEmpty());
  dGeomSetPosition(b, 1001 - dReal{1e-10}, 0, 0);
  EXPECT_THAT(Found(), SizeIs(1));
}

TEST_P(OdeBroadPhaseTest, AnUprightPlaneIsNearTheGeomsInItsHalfSpace) {
  dCreatePlane(space_, 0, 0, 1, 2);
  std::vector<dGeomID> cubes(50);
  for (size_t i = 0; i < cubes.size(); ++i) cubes[i] = Cube(static_cast<dReal>(i) * 2);
  dGeomSetPosition(cubes[7], 1e6, -1e6, 2.4);
  dGeomSetPosition(cubes[8], 0, 0, 2.6);
  for (int step = 0; step < 40; ++step) {  // from the thirtieth step on the geoms rest
    dGeomSetPosition(cubes[9], 0, step, -1e4);
    EXPECT_THAT(Found(), SizeIs(49));
  }
}

TEST_P(OdeBroadPhaseTest, ATiltedPlaneIsNearEachGeom) {
  dCreatePlane(space_, 0.6, 0, 0.8, 0);
  dCreatePlane(space_, 0, 0.6, 0.8, 0);
  for (int i = 0; i < 50; ++i) Cube(i * 2);
  EXPECT_THAT(Found(), SizeIs(101));
  EXPECT_THAT(Found(), SizeIs(101));
}

TEST_P(OdeBroadPhaseTest, BoxesBeyondTheRangeOfFloatAreCompared) {
  const std::vector<dReal> far = {1e39, -1e39, std::numeric_limits<dReal>::infinity(),
                                  std::numeric_limits<dReal>::quiet_NaN()};
  for (const dReal x : far) {
    Cube(x);
    dGeomSetPosition(Cube(x), x, 0, 0.5);
    dGeomSetPosition(Cube(x), x, 0, 5);
  }
  Cube(0);
  EXPECT_THAT(Found(), SizeIs(21));
}

TEST_P(OdeBroadPhaseTest, GeomsOfTheSameBodyAreNotNear) {
  const dGeomID a = Cube(0);
  const dGeomID b = Cube(0);
  const dBodyID body = dBodyCreate(world_);
  EXPECT_THAT(Found(), SizeIs(1));  // both have no body
  dGeomSetBody(a, body);
  EXPECT_THAT(Found(), SizeIs(1));
  dGeomSetBody(b, body);
  EXPECT_THAT(Found(), IsEmpty());
}

TEST_P(OdeBroadPhaseTest, TheCategoryOfOneGeomMustMeetTheCollideBitsOfTheOther) {
  const dGeomID a = Cube(0);
  const dGeomID b = Cube(0);
  dGeomSetCategoryBits(a, 1);
  dGeomSetCategoryBits(b, 2);
  for (const auto& [bits_a, bits_b, count] :
       {std::tuple(1, 2, 0), {2, 2, 1}, {1, 1, 1}, {2, 1, 1}, {0, 0, 0}}) {
    dGeomSetCollideBits(a, static_cast<unsigned long>(bits_a));
    dGeomSetCollideBits(b, static_cast<unsigned long>(bits_b));
    EXPECT_THAT(Found(), SizeIs(count));
  }
}

TEST_P(OdeBroadPhaseTest, DisabledGeomsAreNotNearUntilTheyAreEnabled) {
  const dGeomID a = Cube(0);
  Cube(0);
  EXPECT_THAT(Found(), SizeIs(1));
  dGeomDisable(a);
  EXPECT_THAT(Found(), IsEmpty());
  EXPECT_THAT(Found(), IsEmpty());
  dGeomEnable(a);
  EXPECT_THAT(Found(), SizeIs(1));
}

TEST_P(OdeBroadPhaseTest, ShapesOfZeroSizeAreNotNear) {
  Cube(0);
  const dGeomID box = dCreateBox(space_, 1, 0, 1);
  dCreateSphere(space_, 0);
  dCreateCapsule(space_, 0, 1);
  dCreateCylinder(space_, 1, 0);
  EXPECT_THAT(Found(), IsEmpty());
  dCreateCapsule(space_, 1, 0);  // is a sphere
  EXPECT_THAT(Found(), SizeIs(1));
  dGeomBoxSetLengths(box, 1, 1, 1);
  EXPECT_THAT(Found(), SizeIs(3));
}

TEST_P(OdeBroadPhaseTest, ASpaceInTheSpaceIsOneGeom) {
  const dSpaceID inner = dHashSpaceCreate(space_);
  const dGeomID outer_cube = Cube(0);
  const dGeomID a = Cube(5, inner);
  Cube(5.5, inner);
  EXPECT_THAT(Found(), IsEmpty());
  dGeomSetPosition(a, 0.5, 0, 0);
  EXPECT_EQ(Found(), Pairs({{reinterpret_cast<dGeomID>(inner), outer_cube}}));
}

TEST_P(OdeBroadPhaseTest, FollowsGeomsThatAreDestroyedAndMade) {
  std::vector<dGeomID> cubes;
  size_t pair_count = 0;
  for (int step = 0; step < 60; ++step) {
    cubes.push_back(Cube(step % 7 * 0.5));
    if (step % 3 == 2) {
      dGeomDestroy(cubes[static_cast<size_t>(step) / 3]);
      cubes.erase(cubes.begin() + step / 3);
    }
    if (step % 4 == 0) dGeomSetPosition(cubes.front(), 0.1 * step, 0, 0);
    pair_count += Found().size();
  }
  EXPECT_GT(pair_count, 60U);
}

TEST_P(OdeBroadPhaseTest, AGeomThatLeavesTheSpaceIsNotNear) {
  const dGeomID a = Cube(0);
  Cube(0);
  EXPECT_THAT(Found(), SizeIs(1));
  dSpaceRemove(space_, a);
  EXPECT_THAT(Found(), IsEmpty());
  dSpaceAdd(space_, a);
  EXPECT_THAT(Found(), SizeIs(1));
  dSpaceRemove(space_, a);
  dGeomDestroy(a);
}

// The boxes of NaN and infinity would trap, and those below the range of float would be flushed.
TEST_P(OdeBroadPhaseTest, HasTheSamePairsInEveryFloatingPointEnvironment) {
  for (const dReal x : {dReal{0.1}, dReal{0.2}, dReal{1.3}, dReal{1e39}, dReal{1e-40}}) Cube(x);
  Cube(std::numeric_limits<dReal>::quiet_NaN());
  const Pairs expected = Found();
  EXPECT_THAT(expected, SizeIs(::testing::Gt(5U)));
  for (const FloatMode& mode : FloatModes()) {
    broad_phase_ = std::make_unique<OdeBroadPhase>(*search_, space_);  // reads all boxes again
    Pairs pairs;
    EXPECT_TRUE(KeepsMode(mode, [&] { Collide(pairs); })) << mode.name;
    EXPECT_EQ(pairs, expected) << mode.name;
  }
}

TEST_P(OdeBroadPhaseTest, GeomsThatAreGoneLeaveNoPlaces) {
  for (int i = 0; i < 100; ++i) Cube(i * 0.7);
  const size_t pair_count = Found().size();
  std::vector<dGeomID> burst(3000);
  for (size_t i = 0; i < burst.size(); ++i) burst[i] = Cube(1000 + static_cast<dReal>(i) * 2);
  Found();
  EXPECT_EQ(broad_phase_->place_count(), 3100U);
  for (const dGeomID geom : burst) dGeomDestroy(geom);
  EXPECT_EQ(Found().size(), pair_count);
  EXPECT_EQ(broad_phase_->place_count(), 100U);
  Cube(0.1);
  EXPECT_GT(Found().size(), pair_count);
  EXPECT_EQ(broad_phase_->place_count(), 101U);
}

// FrameSample::pair_count counts the pairs that the arm has found.
TEST_P(OdeBroadPhaseTest, GeomsAtRestAreNotSearchedUntilTheyMove) {
  const dGeomID a = Cube(0);
  const dGeomID b = Cube(0.5);
  for (const dReal height : {0, 1}) {
    dGeomSetPosition(a, 0, 0, height);
    dGeomSetPosition(b, 0.5, 0, height);
    Found();  // the first search with these boxes
    for (int step = 1; step < 30; ++step) {
      EXPECT_THAT(Found(), SizeIs(1));
      EXPECT_EQ(search_->last_sample().pair_count, 1U);
    }
    EXPECT_THAT(Found(), SizeIs(1));
    EXPECT_EQ(search_->last_sample().pair_count, 0U);
  }
  dGeomSetPosition(b, 1.6, 0, 1);
  EXPECT_THAT(Found(), IsEmpty());
}

TEST_P(OdeBroadPhaseTest, ASearchWithTooManyPairsKeepsThePreviousOnes) {
  const dGeomID a = Cube(0);
  const dGeomID b = Cube(0.5);
  const dGeomID moved = Cube(0.6);
  const dGeomID gone = Cube(0.7);
  EXPECT_THAT(Found(), SizeIs(6));
  std::vector<dGeomID> crowd(kTooManyBoxes);
  for (dGeomID& geom : crowd) geom = Cube(50);
  dGeomSetPosition(moved, 5, 0, 0);
  dGeomDestroy(gone);
  for (int step = 0; step < 40; ++step) {  // from the thirtieth step on the geoms rest
    Pairs pairs;
    Collide(pairs);
    ASSERT_TRUE(search_->pairs_exceeded()) << "in step " << step;
    ASSERT_THAT(pairs, SizeIs(1));
    EXPECT_EQ(std::minmax(pairs[0].first, pairs[0].second), std::minmax(a, b));
  }
  for (const dGeomID geom : crowd) dGeomDestroy(geom);
  EXPECT_THAT(Found(), SizeIs(1));
  EXPECT_FALSE(search_->pairs_exceeded());
}

TEST_P(OdeBroadPhaseTest, AStepAllocatesNothingInSteadyState) {
  std::vector<dGeomID> cubes(200);
  for (size_t i = 0; i < cubes.size(); ++i) cubes[i] = Cube(static_cast<dReal>(i) * 0.7);
  Pairs pairs;
  uint64_t before = 0;
  for (int step = 0; step < 100; ++step) {
    if (step == 60) before = ThreadAllocationCount();
    for (size_t i = 0; i < cubes.size(); i += 3)
      dGeomSetPosition(cubes[i], i * 0.7, step % 4 * 0.1, 0);
    pairs.clear();
    Collide(pairs);
  }
  EXPECT_EQ(ThreadAllocationCount(), before);
}

struct Space {
  const char* name;
  dSpaceID (*make)();
};

const Space kSpaces[] = {
    {"Hash", [] { return dHashSpaceCreate(nullptr); }},
    {"SweepAndPrune", [] { return dSweepAndPruneSpaceCreate(nullptr, dSAP_AXES_XYZ); }},
    {"QuadTree",
     [] {
       const dVector3 center = {0, 0, 0};
       const dVector3 extents = {8, 8, 8};
       return dQuadTreeSpaceCreate(nullptr, center, extents, 3);
     }},
};

// The same geoms in a space of each kind and in a simple space, which is the reference: the other
// spaces miss some pairs, or add some.
class OdeSpaceTest : public ::testing::TestWithParam<Space> {
 protected:
  using Numbers = std::set<std::pair<int, int>>;

  OdeSpaceTest() {
    dInitODE2(0);
    dAllocateODEDataForThread(dAllocateMaskAll);
    space_ = GetParam().make();
    reference_ = dSimpleSpaceCreate(nullptr);
  }
  ~OdeSpaceTest() override {
    dSpaceDestroy(space_);
    dSpaceDestroy(reference_);
    dCloseODE();
  }

  dReal Random() { return std::uniform_real_distribution<dReal>(-12, 12)(random_); }

  void Add() {
    const bool is_plane = numbers_.size() % 20 == 0;
    numbers_.push_back(static_cast<int>(numbers_.size()));
    for (const dSpaceID space : {space_, reference_}) {
      const dGeomID geom =
          is_plane ? dCreatePlane(space, 0, 0, 1, -12) : dCreateBox(space, 3, 3, 3);
      dGeomSetData(geom, &numbers_.back());
      (space == space_ ? geoms_ : reference_geoms_).push_back(geom);
    }
    if (!is_plane) Move(geoms_.size() - 1);
  }

  void Move(size_t at) {
    const dReal place[3] = {Random(), Random(), Random()};
    for (const dGeomID geom : {geoms_[at], reference_geoms_[at]}) {
      if (dGeomGetClass(geom) != dPlaneClass) {
        dGeomSetPosition(geom, place[0], place[1], place[2]);
      }
    }
  }

  void RemoveFirst() {
    for (auto* const geoms : {&geoms_, &reference_geoms_}) {
      dGeomDestroy(geoms->front());
      geoms->erase(geoms->begin());
    }
  }

  static void Append(void* numbers, dGeomID a, dGeomID b) {
    const auto [low, high] = std::minmax({NumberOf(a), NumberOf(b)});
    EXPECT_TRUE(static_cast<Numbers*>(numbers)->emplace(low, high).second);
  }
  static int NumberOf(dGeomID geom) { return *static_cast<const int*>(dGeomGetData(geom)); }

  dSpaceID space_;
  dSpaceID reference_;
  std::deque<int> numbers_;
  std::vector<dGeomID> geoms_;
  std::vector<dGeomID> reference_geoms_;
  std::minstd_rand random_{1};
};

INSTANTIATE_TEST_SUITE_P(Each, OdeSpaceTest, ::testing::ValuesIn(kSpaces),
                         [](const auto& space) { return std::string(space.param.name); });

TEST_P(OdeSpaceTest, HasThePairsOfASimpleSpace) {
  const auto search = std::move(*AdaptiveBroadPhase::Create(OneArm("KDTree"), nullptr));
  OdeBroadPhase broad_phase(*search, space_);
  for (int i = 0; i < 80; ++i) Add();
  for (size_t step = 0; step < 100; ++step) {
    for (size_t at = step % 7; at < geoms_.size(); at += 7) Move(at);
    if (step % 3 == 0) Add();
    if (step % 3 == 1) RemoveFirst();
    const size_t switched = random_() % geoms_.size();
    for (const dGeomID geom : {geoms_[switched], reference_geoms_[switched]}) {
      dGeomIsEnabled(geom) != 0 ? dGeomDisable(geom) : dGeomEnable(geom);
    }
    Numbers ours;
    Numbers theirs;
    search->BeginFrame();
    broad_phase.Collide(&ours, Append);
    search->EndFrame({});
    dSpaceCollide(reference_, &theirs, Append);
    ASSERT_EQ(ours, theirs) << "step " << step;
    EXPECT_GT(ours.size(), 10U);
  }
}

}  // namespace
}  // namespace sweepstake::test_support
