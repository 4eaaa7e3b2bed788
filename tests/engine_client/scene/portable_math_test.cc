#include "engine_client/scene/portable_math.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "engine_client/scene/counter_random.h"

namespace sweepstake {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kTwoUlp = 2 * std::numeric_limits<double>::epsilon();

// The C library serves as the reference here: it is within an ulp, though not the same everywhere.
void ExpectNear(double actual, double expected, double x) {
  EXPECT_LE(std::fabs(actual - expected), kTwoUlp * std::fabs(expected) + 1e-300) << "at " << x;
}

double InRange(int i, double low, double high) {
  const CounterRandom random(7, RandomStream::kKick);
  return low + (high - low) * random.Unit(0, i);
}

TEST(PortableMath, SinAndCosFollowTheReferenceOverManyTurns) {
  for (int i = 0; i < 20000; ++i) {
    const double x = InRange(i, -1000, 1000);
    EXPECT_NEAR(portable::Sin(x), std::sin(x), kTwoUlp) << "at " << x;
    EXPECT_NEAR(portable::Cos(x), std::cos(x), kTwoUlp) << "at " << x;
  }
}

TEST(PortableMath, ExpFollowsTheReferenceOverItsWholeRange) {
  for (int i = 0; i < 20000; ++i) {
    const double x = InRange(i, -708, 709);
    ExpectNear(portable::Exp(x), std::exp(x), x);
  }
}

TEST(PortableMath, LogFollowsTheReferenceNearAndFarFromOne) {
  for (int i = 0; i < 20000; ++i) {
    const double near = InRange(i, 0.5, 2);
    ExpectNear(portable::Log(near), std::log(near), near);
    const double far = portable::Exp(InRange(i, -700, 700));
    ExpectNear(portable::Log(far), std::log(far), far);
  }
}

TEST(PortableMath, PowAndCubeRootFollowTheReference) {
  for (int i = 0; i < 20000; ++i) {
    const double x = InRange(i, 0, 1);
    EXPECT_NEAR(portable::Pow(x, 0.75), std::pow(x, 0.75), 8 * kTwoUlp) << "at " << x;
    const double volume = InRange(i, 1, 1e7);
    // In double some libraries' cbrt is off by more than ours.
    const long double reference = std::cbrt(static_cast<long double>(volume));
    ExpectNear(portable::CubeRoot(volume), static_cast<double>(reference), volume);
  }
}

TEST(PortableMath, LimitsAreWhatTheHeaderSays) {
  EXPECT_EQ(portable::Exp(0), 1);
  EXPECT_EQ(portable::Exp(1000), kInfinity);
  EXPECT_EQ(portable::Exp(-1000), 0);
  EXPECT_EQ(portable::Exp(-kInfinity), 0);
  EXPECT_EQ(portable::Log(1), 0);
  EXPECT_EQ(portable::Log(0), -kInfinity);
  EXPECT_EQ(portable::Log(kInfinity), kInfinity);
  EXPECT_NEAR(portable::Log(5e-324), std::log(5e-324), 1e-12);
  EXPECT_EQ(portable::Pow(0, 0.75), 0);
  EXPECT_EQ(portable::Pow(0, 0), 1);
  EXPECT_EQ(portable::CubeRoot(0), 0);
  EXPECT_EQ(portable::Sin(0), 0);
  EXPECT_EQ(portable::Cos(0), 1);
}

TEST(PortableMath, WhatHasNoValueIsNan) {
  for (const double x : {kInfinity, -kInfinity, std::nan(""), 1e16}) {
    EXPECT_TRUE(std::isnan(portable::Sin(x))) << x;
    EXPECT_TRUE(std::isnan(portable::Cos(x))) << x;
  }
  EXPECT_TRUE(std::isnan(portable::Log(-1)));
  EXPECT_TRUE(std::isnan(portable::Log(std::nan(""))));
  EXPECT_TRUE(std::isnan(portable::Exp(std::nan(""))));
}

}  // namespace
}  // namespace sweepstake
