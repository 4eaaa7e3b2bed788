// This file is compiled with -ffast-math, as some games are. The compiler then assumes that no
// number is NaN or infinite.
#include <gtest/gtest.h>

#include <bit>
#include <cstdint>

#include "sweepstake/aabb.h"

namespace sweepstake {
namespace {

// The compiler cannot know the value.
template <typename Float, typename Bits>
Float Opaque(Bits bits) {
  volatile Bits opaque = bits;
  return std::bit_cast<Float>(static_cast<Bits>(opaque));
}

constexpr uint32_t kNan = 0x7FC0'0000;
constexpr uint32_t kInfinity = 0x7F80'0000;
constexpr uint32_t kSign = 0x8000'0000;
constexpr uint32_t kOne = 0x3F80'0000;

Aabb BoxOf(uint32_t min, uint32_t max) {
  const auto low = Opaque<float>(min);
  const auto high = Opaque<float>(max);
  return {{low, low, low}, {high, high, high}};
}

TEST(FastMath, BoxesWithNanOrInfinityAreInvalidAndOverlapNothing) {
  const Aabb unit = BoxOf(0, kOne);
  for (const uint32_t broken : {kNan, kNan | kSign, kInfinity, kInfinity | kSign}) {
    for (const Aabb& box : {BoxOf(broken, kOne), BoxOf(0, broken), BoxOf(broken, broken)}) {
      EXPECT_FALSE(IsValid(box)) << std::hex << broken;
      EXPECT_FALSE(Overlap(box, unit)) << std::hex << broken;
      EXPECT_FALSE(Overlap(unit, box)) << std::hex << broken;
    }
  }
  EXPECT_TRUE(IsValid(unit));
  EXPECT_TRUE(Overlap(unit, BoxOf(kOne, kOne)));
  EXPECT_FALSE(Overlap(unit, BoxOf(kOne + 1, kOne + 1)));
}

TEST(FastMath, RoundingADoubleThatIsNanGivesAnInvalidBox) {
  const auto nan = Opaque<double>(uint64_t{0x7FF8'0000'0000'0000});
  const double broken[3] = {nan, nan, nan};
  const double unit[3] = {1, 1, 1};
  EXPECT_FALSE(IsValid(RoundOutward(broken, unit)));
  EXPECT_FALSE(IsValid(RoundOutward(unit, broken)));
  EXPECT_TRUE(IsValid(RoundOutward(unit, unit)));
}

}  // namespace
}  // namespace sweepstake
