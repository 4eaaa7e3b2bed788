#include "engine_client/scene/portable_math.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace sweepstake::portable {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// pi/2 and ln 2 as sums; the leading parts have few bits, so that their product with a quotient is
// exact.
constexpr double kHalfPiHigh = 0x1.921fb544p+0;
constexpr double kHalfPiMiddle = 0x1.0b4611a6p-34;
constexpr double kHalfPiLow = 0x1.3198a2e037073p-69;
constexpr double kTwoOverPi = 0x1.45f306dc9c883p-1;
constexpr double kLn2High = 0x1.62e42fefa2p-1;
constexpr double kLn2Low = 0x1.9ef35793c7673p-41;
constexpr double kOneOverLn2 = 0x1.71547652b82fep+0;
constexpr double kSqrtHalf = 0x1.6a09e667f3bcdp-1;

// REQUIRES: |x| < 2^62.
int64_t Nearest(double x) { return static_cast<int64_t>(x < 0 ? x - 0.5 : x + 0.5); }

struct Reduced {
  double rest;        // in about [-pi/4, pi/4]
  uint32_t quadrant;  // 0 to 3
};

Reduced ReduceToQuadrant(double x) {
  const int64_t quotient = Nearest(x * kTwoOverPi);
  const double k = static_cast<double>(quotient);
  const double rest = ((x - k * kHalfPiHigh) - k * kHalfPiMiddle) - k * kHalfPiLow;
  return {rest, static_cast<uint32_t>(quotient) & 3U};
}

bool HasAngle(double x) { return x > -1e15 && x < 1e15; }

// Taylor series; on [-pi/4, pi/4] the first term left out is below 1e-16 of the result.
double SinSeries(double x) {
  const double s = x * x;
  double sum = -1.0 / 1307674368000.0;
  sum = sum * s + 1.0 / 6227020800.0;
  sum = sum * s - 1.0 / 39916800.0;
  sum = sum * s + 1.0 / 362880.0;
  sum = sum * s - 1.0 / 5040.0;
  sum = sum * s + 1.0 / 120.0;
  sum = sum * s - 1.0 / 6.0;
  return x + x * (s * sum);
}

double CosSeries(double x) {
  const double s = x * x;
  double sum = 1.0 / 20922789888000.0;
  sum = sum * s - 1.0 / 87178291200.0;
  sum = sum * s + 1.0 / 479001600.0;
  sum = sum * s - 1.0 / 3628800.0;
  sum = sum * s + 1.0 / 40320.0;
  sum = sum * s - 1.0 / 720.0;
  sum = sum * s + 1.0 / 24.0;
  return 1.0 - (0.5 * s - s * s * sum);
}

double SinOfQuadrant(double rest, uint32_t quadrant) {
  const double value = (quadrant & 1U) != 0 ? CosSeries(rest) : SinSeries(rest);
  return (quadrant & 2U) != 0 ? -value : value;
}

// 2^exponent. REQUIRES: -1022 <= exponent <= 1023.
double PowerOfTwo(int64_t exponent) {
  return std::bit_cast<double>(static_cast<uint64_t>(exponent + 1023) << 52U);
}

// e^x for |x| <= ln(2)/2.
double ExpSeries(double x) {
  double sum = 1.0;
  for (int n = 14; n >= 2; --n) sum = 1.0 + sum * x / n;
  return 1.0 + x * sum;
}

// 2 atanh(s) for |s| <= 0.172.
double LogSeries(double s) {
  const double square = s * s;
  double sum = 0;
  for (int n = 23; n >= 3; n -= 2) sum = (sum + 1.0 / n) * square;
  return 2.0 * s + 2.0 * s * sum;
}

}  // namespace

double Sin(double x) {
  if (!HasAngle(x)) return kNan;
  const Reduced reduced = ReduceToQuadrant(x);
  return SinOfQuadrant(reduced.rest, reduced.quadrant);
}

double Cos(double x) {
  if (!HasAngle(x)) return kNan;
  const Reduced reduced = ReduceToQuadrant(x);
  return SinOfQuadrant(reduced.rest, reduced.quadrant + 1U);
}

double Exp(double x) {
  if (std::isnan(x)) return x;
  if (x > 709.7827128933840) return kInfinity;
  if (x < -708.3964185322641) return 0;
  const int64_t quotient = Nearest(x * kOneOverLn2);
  const double k = static_cast<double>(quotient);
  const double series = ExpSeries((x - k * kLn2High) - k * kLn2Low);
  return series * PowerOfTwo(quotient - 1) * 2.0;
}

double Log(double x) {
  if (std::isnan(x) || x < 0) return kNan;
  if (x == 0) return -kInfinity;
  if (std::isinf(x)) return x;
  if (x < std::numeric_limits<double>::min()) return Log(x * 0x1p54) - 54 * (kLn2High + kLn2Low);
  const uint64_t bits = std::bit_cast<uint64_t>(x);
  int64_t exponent = static_cast<int64_t>(bits >> 52U) - 1022;
  double mantissa = std::bit_cast<double>((bits & 0x000FFFFFFFFFFFFFU) | 0x3FE0000000000000U);
  if (mantissa < kSqrtHalf) {
    mantissa *= 2;
    --exponent;
  }
  const double series = LogSeries((mantissa - 1) / (mantissa + 1));
  const double k = static_cast<double>(exponent);
  return k * kLn2High + (series + k * kLn2Low);
}

double Pow(double base, double exponent) {
  if (exponent == 0) return 1;
  return Exp(exponent * Log(base));
}

double CubeRoot(double x) {
  if (x == 0) return 0;
  const double near = Exp(Log(x) / 3);
  return near - (near * near * near - x) / (3 * near * near);
}

}  // namespace sweepstake::portable
