#include "server/decision/math/sampling.h"

#include <algorithm>
#include <cmath>  // std::sqrt, exactly rounded by IEEE 754

#include "server/decision/math/portable_math.h"

namespace sweepstake::decision {
namespace {

constexpr double kSmallestShape = 1e-300;

// REQUIRES: shape >= 1.
double DrawLogGammaFromOne(double shape, RandomStream& stream) {
  const double d = shape - 1.0 / 3.0;
  const double c = 1 / std::sqrt(9 * d);
  for (;;) {
    const double x = DrawNormal(stream);
    const double root = 1 + c * x;
    if (root <= 0) continue;
    const double v = root * root * root;
    const double u = stream.NextUniform();
    const double log_v = PortableLog(v);
    if (PortableLog(u) < 0.5 * x * x + d * (1 - v + log_v)) return PortableLog(d) + log_v;
  }
}

}  // namespace

double DrawNormal(RandomStream& stream) {
  for (;;) {
    const double u = 2 * stream.NextUniform() - 1;
    const double v = 2 * stream.NextUniform() - 1;
    const double s = u * u + v * v;
    if (s > 0 && s < 1) return u * std::sqrt(-2 * PortableLog(s) / s);
  }
}

double DrawLogGamma(double shape, RandomStream& stream) {
  if (shape >= 1) return DrawLogGammaFromOne(shape, stream);
  // Gamma(a) = Gamma(a + 1) · U^(1/a).
  const double a = std::max(shape, kSmallestShape);
  const double log_boosted = DrawLogGammaFromOne(a + 1, stream);
  return log_boosted + PortableLog(stream.NextUniform()) / a;
}

double DrawBeta(const BetaPosterior& posterior, RandomStream& stream) {
  const double log_x = DrawLogGamma(posterior.alpha, stream);
  const double log_y = DrawLogGamma(posterior.beta, stream);
  return 1 / (1 + PortableExp(log_y - log_x));
}

}  // namespace sweepstake::decision
