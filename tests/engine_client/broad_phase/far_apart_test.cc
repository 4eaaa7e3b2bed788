// Tests the bounds on work and memory in scenes whose boxes are far apart. An adaptive broad phase
// tries every backend, so that none may be much slower than the others.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "engine_client/scene/box_scenes.h"
#include "tests/engine_client/broad_phase/backend_under_test.h"

namespace sweepstake {
namespace {

using test_support::MakeOrThrow;
using test_support::Sorted;

enum class Shape { kCrowds, kCorners, kExponential, kOutlier, kLine, kDiagonal };

constexpr Shape kShapes[] = {Shape::kCrowds,  Shape::kCorners, Shape::kExponential,
                             Shape::kOutlier, Shape::kLine,    Shape::kDiagonal};

std::string_view KindOf(Shape shape) {
  return shape == Shape::kCrowds        ? "far-crowds"
         : shape == Shape::kExponential ? "exponential-spacing"
                                        : "brownian";
}

// Moves a box of a brownian scene to its place in the shape.
void Place(Shape shape, size_t index, Aabb& box) {
  for (int axis = 0; axis < 3; ++axis) {
    float shift = 0;
    if (shape == Shape::kCorners) shift = (index >> axis & 1) != 0 ? 10'000.0F : 0;
    if (shape == Shape::kOutlier && index == 7) shift = 1e6F;
    if (shape == Shape::kDiagonal || (shape == Shape::kLine && axis == 0))
      shift = static_cast<float>(index) - box.min[axis];
    if (shape == Shape::kLine && axis != 0) shift = -box.min[axis];
    box.min[axis] += shift;
    box.max[axis] += shift;
  }
}

std::vector<Aabb> BoxesIn(Shape shape, const BoxScene& scene) {
  std::vector<Aabb> boxes(scene.boxes().begin(), scene.boxes().end());
  for (size_t i = 0; i < boxes.size(); ++i) Place(shape, i, boxes[i]);
  return boxes;
}

// Returns the maximum mean number of AABB checks per box and frame.
uint64_t MaxChecks(std::string_view backend, size_t count) {
  if (backend == "BruteForce") return count / 2 + 100;
  if (backend == "SAP" || backend == "AxisSweep") return 600;
  return 80;
}

class FarApart : public testing::TestWithParam<std::string_view> {};

TEST_P(FarApart, BoxesNeedFewChecksAndLittleMemory) {
  constexpr int kFrames = 40;
  constexpr size_t kMaxBytes = 20'000'000;
  for (const Shape shape : kShapes) {
    const size_t count = shape == Shape::kExponential ? 20'000 : 10'000;
    BoxScene scene(KindOf(shape), count, 3);
    const auto backend = MakeOrThrow(GetParam());
    const auto other = MakeOrThrow("KDTree");
    PairBuffer pairs;
    PairBuffer other_pairs;
    uint64_t checks = 0;
    for (int frame = 0; frame < kFrames; ++frame, scene.Step()) {
      const std::vector<Aabb> boxes = BoxesIn(shape, scene);
      frame == 0 ? backend->Build(boxes) : backend->Update(boxes);
      pairs.Clear();
      backend->FindPairs(pairs);
      checks += backend->aabb_check_count();
      ASSERT_LE(backend->native_bytes() + pairs.capacity_bytes(), kMaxBytes);
      if (frame % 13 != 0) continue;
      other->Build(boxes);
      other_pairs.Clear();
      other->FindPairs(other_pairs);
      ASSERT_EQ(Sorted(pairs.pairs()), Sorted(other_pairs.pairs())) << static_cast<int>(shape);
    }
    EXPECT_LE(checks / kFrames / count, MaxChecks(GetParam(), count)) << static_cast<int>(shape);
  }
}

INSTANTIATE_TEST_SUITE_P(, FarApart,
                         testing::ValuesIn(BroadPhaseNames().begin(), BroadPhaseNames().end()),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace sweepstake
