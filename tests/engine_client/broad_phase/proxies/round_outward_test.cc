#include "sweepstake/aabb.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine_client/scene/random.h"

namespace sweepstake {
namespace {

constexpr float kBeyondAll = std::numeric_limits<float>::infinity();
constexpr float kLargestFloat = (std::numeric_limits<float>::max)();
constexpr float kLeastFloat = std::numeric_limits<float>::denorm_min();

Aabb Rounded(double min, double max) {
  const double mins[3] = {min, min, min};
  const double maxs[3] = {max, max, max};
  return RoundOutward(mins, maxs);
}

void ExpectRounded(double min, double max, float expected_min, float expected_max) {
  const Aabb box = Rounded(min, max);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(box.min[axis], expected_min) << min;
    EXPECT_EQ(box.max[axis], expected_max) << max;
  }
}

TEST(RoundingOutward, DoesNotChangeFloats) {
  ExpectRounded(-1.5, 0.25, -1.5F, 0.25F);
  ExpectRounded(-double{kLargestFloat}, double{kLargestFloat}, -kLargestFloat, kLargestFloat);
  ExpectRounded(-double{kLeastFloat}, double{kLeastFloat}, -kLeastFloat, kLeastFloat);
}

TEST(RoundingOutward, TakesTheNextFloatOutside) {
  ExpectRounded(0.1, 0.1, std::nextafter(0.1F, 0.0F), 0.1F);
  ExpectRounded(1 + 1e-12, 1 + 1e-12, 1, std::nextafter(1.0F, 2.0F));
  ExpectRounded(-1 - 1e-12, -1 - 1e-12, -std::nextafter(1.0F, 2.0F), -1);
  ExpectRounded(-1e-300, 1e-300, -kLeastFloat, kLeastFloat);
  ExpectRounded(1e-300, 1e-300, 0, kLeastFloat);
}

TEST(RoundingOutward, GivesAnInvalidBoxBeyondTheLargestFloat) {
  ExpectRounded(1e300, 1e300, kLargestFloat, kBeyondAll);
  ExpectRounded(-1e300, -1e300, -kBeyondAll, -kLargestFloat);
  EXPECT_FALSE(IsValid(Rounded(0, 1e39)));
  EXPECT_FALSE(IsValid(Rounded(0, std::numeric_limits<double>::infinity())));
  EXPECT_FALSE(IsValid(Rounded(std::numeric_limits<double>::quiet_NaN(), 1)));
  EXPECT_FALSE(IsValid(Rounded(2, 1)));
}

// Tests each axis alone, so that no other axis makes the box invalid.
TEST(RoundingOutward, KeepsABoxInvertedByLessThanOneFloatInvalid) {
  for (size_t axis = 0; axis < 3; ++axis) {
    const auto is_valid = [axis](double min, double max) {
      double mins[3] = {0, 0, 0};
      double maxs[3] = {1, 1, 1};
      mins[axis] = min;
      maxs[axis] = max;
      return IsValid(RoundOutward(mins, maxs));
    };
    EXPECT_TRUE(is_valid(0.1, 0.1));
    EXPECT_FALSE(is_valid(1 + 1e-12, 1));
    EXPECT_FALSE(is_valid(0.1, std::nextafter(0.1, 0.0)));
    EXPECT_FALSE(is_valid(1e-300, -1e-300));
    EXPECT_FALSE(is_valid(std::numeric_limits<double>::quiet_NaN(), 1));
    EXPECT_FALSE(is_valid(0, std::numeric_limits<double>::quiet_NaN()));
  }
}

TEST(RoundingOutward, ContainsWithinOneFloatOnEachSide) {
  SequentialRandom random(1);
  for (int k = 0; k < 10'000; ++k) {
    const double scale = std::pow(10.0, random.Between(-44, 38));
    const double a = scale * random.Symmetric() / 3;
    const double b = scale * random.Symmetric() / 3;
    const Aabb box = Rounded((std::min)(a, b), (std::max)(a, b));
    ASSERT_TRUE(IsValid(box));
    ASSERT_LE(box.min[0], (std::min)(a, b));
    ASSERT_GE(box.max[0], (std::max)(a, b));
    ASSERT_GT(std::nextafter(box.min[0], kBeyondAll), (std::min)(a, b));
    ASSERT_LT(std::nextafter(box.max[0], -kBeyondAll), (std::max)(a, b));
  }
}

}  // namespace
}  // namespace sweepstake
