#include "engine_client/math/normal_distribution.h"

#include <algorithm>
#include <cmath>  // std::abs

#include "engine_client/math/portable_math.h"

namespace sweepstake::decision {
namespace {

constexpr double kInverseSqrtTwoPi = 0x1.9884533d43651p-2;
// Above this |z| the continued fraction is used. With kFractionDepth terms its error at z = 3 is
// 1e-14.
constexpr double kTail = 3;
constexpr int kFractionDepth = 100;
constexpr double kUnderflow = 38;

// Returns (Φ(z) − ½) ÷ φ(z) = z + z³/3 + z⁵/(3·5) + … (G. Marsaglia, "Evaluating the normal
// distribution", Journal of Statistical Software 11, 2004). The terms fall below kPrecision of the
// sum in any rounding mode. REQUIRES: |z| <= kTail.
double CentralSeries(double z) {
  constexpr double kPrecision = 1e-17;
  double sum = z;
  double term = z;
  for (double odd = 3; std::abs(term) > kPrecision * std::abs(sum); odd += 2) {
    term *= z * z / odd;
    sum += term;
  }
  return sum;
}

// Returns Mills' ratio (1 − Φ(z)) ÷ φ(z), by Laplace's continued fraction.
double MillsRatio(double z) {
  double denominator = z;
  for (int k = kFractionDepth; k > 0; --k) denominator = z + k / denominator;
  return 1 / denominator;
}

}  // namespace

double NormalDensity(double z) { return kInverseSqrtTwoPi * math::Exp(-0.5 * z * z); }

double NormalCdf(double z) {
  if (z != z) return z;
  if (z < -kUnderflow) return 0;
  if (z > kTail) return 1 - NormalCdf(-z);
  if (z < -kTail) return NormalDensity(z) * MillsRatio(-z);
  return 0.5 + NormalDensity(z) * CentralSeries(z);
}

double ExpectedGain(double mean, double deviation) {
  if (!(deviation > 0)) return std::max(mean, 0.0);
  const double z = mean / deviation;
  return std::max(mean * NormalCdf(z) + deviation * NormalDensity(z), 0.0);
}

}  // namespace sweepstake::decision
