#include "engine_client/math/portable_math.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace sweepstake::math {
namespace {

// ln 2 in two parts. The high one ends in 21 zero bits, so that k × high is exact for every
// exponent k.
constexpr double kLn2High = 0x1.62e42fee00000p-1;
constexpr double kLn2Low = 0x1.a39ef35793c76p-33;
constexpr double kInverseLn2 = 0x1.71547652b82fep+0;
constexpr double kSqrtHalf = 0x1.6a09e667f3bcdp-1;
// π/2 in three parts. The first two have few bits, so that their products with the integer k in
// ReduceToQuadrant are exact.
constexpr double kHalfPiHigh = 0x1.921fb544p+0;
constexpr double kHalfPiMiddle = 0x1.0b4611a6p-34;
constexpr double kHalfPiLow = 0x1.3198a2e037073p-69;
constexpr double kTwoOverPi = 0x1.45f306dc9c883p-1;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kSmallestNormal = std::numeric_limits<double>::min();

// Returns 2^k. REQUIRES: −1022 <= k <= 1023.
double PowerOfTwo(int k) { return std::bit_cast<double>(static_cast<uint64_t>(k + 1023) << 52); }

// The coefficients 1/n! of the series of exp(r) for n = 2 … 13. The remainder is below 2⁻⁵⁷ for |r|
// <= ln(2)/2.
constexpr std::array<double, 12> kInverseFactorials = [] {
  std::array<double, 12> result{};
  double factorial = 1;
  for (size_t i = 0; i < result.size(); ++i) {
    factorial *= static_cast<double>(i + 2);
    result[i] = 1.0 / factorial;
  }
  return result;
}();

// The coefficients 1/3, 1/5 … 1/25 of the series of artanh(s), enough for s² <= 0.0295.
constexpr std::array<double, 12> kInverseOdd = [] {
  std::array<double, 12> result{};
  for (size_t i = 0; i < result.size(); ++i) result[i] = 1.0 / static_cast<double>(2 * i + 3);
  return result;
}();

// Returns c[0] + c[1] x + c[2] x² + …
double Polynomial(const std::array<double, 12>& coefficients, double x) {
  double sum = 0;
  for (size_t i = coefficients.size(); i-- > 0;) sum = sum * x + coefficients[i];
  return sum;
}

// Returns ln(m) for √½ <= m < √2 as 2 artanh(s) with s = f / (2 + f), f = m − 1. Since 2s = f − s
// f, the leading term is exact.
double LogOfMantissa(double m) {
  const double f = m - 1;
  const double s = f / (2 + f);
  const double square = s * s;
  return f - s * (f - 2 * square * Polynomial(kInverseOdd, square));
}

struct ReducedAngle {
  double rest = 0;        // in about [−π/4, π/4]
  uint32_t quadrant = 0;  // 0 to 3
};

// REQUIRES: HasAngle(x).
ReducedAngle ReduceToQuadrant(double x) {
  const double turns = x * kTwoOverPi;
  const auto quotient = static_cast<int64_t>(turns < 0 ? turns - 0.5 : turns + 0.5);
  const double k = static_cast<double>(quotient);
  const double rest = ((x - k * kHalfPiHigh) - k * kHalfPiMiddle) - k * kHalfPiLow;
  return {rest, static_cast<uint32_t>(quotient) & 3U};
}

bool HasAngle(double x) { return x > -1e15 && x < 1e15; }

// Returns sin(x) by Taylor's series. On [−π/4, π/4] the first omitted term is below 1e-16 of the
// result.
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

// Returns sin(rest + quadrant · π/2).
double SinOfQuadrant(double rest, uint32_t quadrant) {
  const double value = (quadrant & 1U) != 0 ? CosSeries(rest) : SinSeries(rest);
  return (quadrant & 2U) != 0 ? -value : value;
}

}  // namespace

double Exp(double x) {
  if (x != x) return x;
  if (x > 709.79) return kInfinity;
  if (x < -745.14) return 0;
  const int k = static_cast<int>(x * kInverseLn2 + (x < 0 ? -0.5 : 0.5));
  const double r = (x - k * kLn2High) - k * kLn2Low;
  const double mantissa = 1 + (r + r * r * Polynomial(kInverseFactorials, r));
  // Multiplies by two factors, since 2^k alone may be out of range although the result is not.
  const int half = k / 2;
  return mantissa * PowerOfTwo(half) * PowerOfTwo(k - half);
}

double Log(double x) {
  if (x != x || x < 0) return kNaN;
  if (x == 0) return -kInfinity;
  if (x == kInfinity) return x;
  int k = 0;
  if (x < kSmallestNormal) {
    x *= PowerOfTwo(54);
    k = -54;
  }
  const uint64_t bits = std::bit_cast<uint64_t>(x);
  k += static_cast<int>(bits >> 52) - 1022;
  double m = std::bit_cast<double>((bits & 0x000f'ffff'ffff'ffff) | 0x3fe0'0000'0000'0000);
  if (m < kSqrtHalf) {
    m *= 2;
    --k;
  }
  return k * kLn2High + (LogOfMantissa(m) + k * kLn2Low);
}

double Expm1(double x) {
  // For such an argument Exp uses k = 0. Its series without the leading 1 gives the result without
  // loss of digits.
  if (x > -0.34 && x < 0.34) return x + x * x * Polynomial(kInverseFactorials, x);
  return Exp(x) - 1;
}

double Log1p(double x) {
  const double sum = 1 + x;
  if (sum == 1) return x;
  // W. Kahan's correction of the rounding error of `sum`. ln(s) / (s − 1) varies slowly, so that a
  // small error of s hardly changes it.
  return sum < kInfinity && sum > 0 ? Log(sum) * (x / (sum - 1)) : Log(sum);
}

double Sin(double x) {
  if (!HasAngle(x)) return kNaN;
  const ReducedAngle angle = ReduceToQuadrant(x);
  return SinOfQuadrant(angle.rest, angle.quadrant);
}

double Cos(double x) {
  if (!HasAngle(x)) return kNaN;
  const ReducedAngle angle = ReduceToQuadrant(x);
  return SinOfQuadrant(angle.rest, angle.quadrant + 1U);
}

double Pow(double base, double exponent) {
  if (exponent == 0) return 1;
  return Exp(exponent * Log(base));
}

double CubeRoot(double x) {
  if (x == 0) return 0;
  const double near = Exp(Log(x) / 3);
  // One step of Newton's method.
  return near - (near * near * near - x) / (3 * near * near);
}

}  // namespace sweepstake::math
