#include "engine_client/math/beta_distribution.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>  // std::sqrt, exactly rounded by IEEE 754

#include "engine_client/math/portable_math.h"

namespace sweepstake::decision {
namespace {

constexpr double kHalfLog2Pi = 0x1.d67f1c864beb5p-1;
// At and above this argument Stirling's series up to x^−11 is exact to the last place.
constexpr double kStirlingFrom = 15;
// If both parameters exceed this, the tail is integrated, since the series would need too many
// terms.
constexpr double kSumFrom = 3000;

// Returns (x − ½) ln x − x + ½ ln 2π, which is ln Γ(x) without Stirling's error.
double StirlingLeading(double x) { return (x - 0.5) * math::Log(x) - x + kHalfLog2Pi; }

// Returns Stirling's series, the sum of B₂ₖ / (2k (2k − 1) x^(2k − 1)) for k = 1 … 6, where B₂ₖ are
// the Bernoulli numbers. REQUIRES: x >= kStirlingFrom.
double StirlingSeries(double x) {
  constexpr std::array<double, 6> kTerms = {1.0 / 12,    -1.0 / 360, 1.0 / 1260,
                                            -1.0 / 1680, 1.0 / 1188, -691.0 / 360360};
  const double inverse = 1 / x;
  const double square = inverse * inverse;
  double sum = 0;
  for (size_t i = kTerms.size(); i-- > 0;) sum = sum * square + kTerms[i];
  return sum * inverse;
}

// Returns ln Γ(x) − StirlingLeading(x).
double StirlingError(double x) {
  return x >= kStirlingFrom ? StirlingSeries(x) : LogGamma(x) - StirlingLeading(x);
}

struct UnitPoint {
  double x = 0;  // a point of [0, 1]
  double y = 0;  // 1 − x, without loss of digits
};

UnitPoint FromLogit(double logit) {
  const double e = math::Exp(logit < 0 ? logit : -logit);
  const double small = e / (1 + e);
  const double large = 1 / (1 + e);
  return logit < 0 ? UnitPoint{small, large} : UnitPoint{large, small};
}

// Returns the series S of I_x(α, β) = x^α (1 − x)^β / (α B) × S (DLMF 8.17.8). All terms are
// positive; around the mean, about √α terms are needed. REQUIRES: x <= ½, and 1 − I_x is not
// negligible.
double IncompleteBetaSeries(const BetaPosterior& p, double x) {
  constexpr double kPrecision = 1e-17;
  const double n = p.alpha + p.beta;
  double term = 1;
  double sum = 1;
  for (double k = 0; term > kPrecision * sum; ++k) {
    term *= (n + k) / (p.alpha + 1 + k) * x;
    sum += term;
  }
  return sum;
}

// Returns P(logit <= mode + offset) by the trapezoidal rule, with Euler–Maclaurin corrections at
// the end up to the third derivative. Its steps are a twelfth of the scale on which the density
// changes. The relative error is then below 1e-10. REQUIRES: offset <= 0, α >= 1, and both
// parameters are large or the logit is above 0.
double SummedTail(const BetaPosterior& p, double offset) {
  constexpr double kPrecision = 1e-17;
  const double n = p.alpha + p.beta;
  const UnitPoint at = FromLogit(LogitMode(p) + offset);
  // This is the slope of the density's logarithm.
  const double slope = p.alpha * at.y - p.beta * at.x;
  const double h = 1 / (12 * std::max({1.0, std::sqrt(p.alpha / n * p.beta), slope / 8}));
  double sum = 0;
  double term = 1;
  for (int i = 1; term > kPrecision * sum; ++i) {
    term = math::Exp(LogitLogShape(p, offset - i * h));
    sum += term;
  }
  const double first = h * slope;
  const double second = -h * h * n * at.x * at.y;
  const double third = second * h * (at.y - at.x);
  const double end_terms = 0.5 - first / 12 + (first * (first * first + 3 * second) + third) / 720;
  sum += end_terms * math::Exp(LogitLogShape(p, offset));
  return math::Exp(LogitLogPeak(p)) * h * sum;
}

// Returns P(logit <= mode + offset) by IncompleteBetaSeries. REQUIRES: the logit is at most 0.
double SeriesTail(const BetaPosterior& p, double offset) {
  constexpr double kNegligible = -45;
  const double log_shape = LogitLogShape(p, offset);
  if (offset > 0 && log_shape < kNegligible) return 1;
  const double density = math::Exp(LogitLogPeak(p) + log_shape);
  return density / p.alpha * IncompleteBetaSeries(p, FromLogit(LogitMode(p) + offset).x);
}

// Returns P(logit <= mode + offset). Below the mean this computes the lower tail, above it 1 − the
// upper tail, so that small results have all their digits.
double TailAt(const BetaPosterior& p, double offset) {
  const bool large = std::min(p.alpha, p.beta) > kSumFrom;
  if (!large && LogitMode(p) + offset <= 0) return SeriesTail(p, offset);
  // For α < 1 the density falls too slowly to be integrated. The lower tail is then not small where
  // the logit is above 0, so that 1 − the upper tail keeps its digits.
  if (offset <= 0 && p.alpha >= 1) return SummedTail(p, offset);
  return 1 - (large ? SummedTail(Mirrored(p), -offset) : SeriesTail(Mirrored(p), -offset));
}

double DistributionAt(const BetaPosterior& p, double offset) {
  return std::clamp(TailAt(p, offset), 0.0, 1.0);
}

// Returns the offset from the mode below which the distribution has mass p. The logarithm of the
// distribution function is concave, so Newton's steps approach from below without overshooting.
// REQUIRES: 0 < p <= 0.5.
double OffsetOfLowerTail(const BetaPosterior& posterior, double p) {
  constexpr int kMaxStep = 100;
  const double log_peak = LogitLogPeak(posterior);
  const double log_p = math::Log(p);
  double offset = 0;
  double step = 0;
  for (int i = 0; i < kMaxStep; ++i) {
    const double below = DistributionAt(posterior, offset);
    const double density = math::Exp(log_peak + LogitLogShape(posterior, offset));
    // If the tail is empty, the last step was too long, and half of it is undone.
    step = below > 0 && density > 0 ? (log_p - math::Log(below)) * (below / density)
                                    : std::abs(step) / 2;
    offset += step;
    if (std::abs(step) <= 1e-14 * std::abs(offset)) break;
  }
  return offset;
}

}  // namespace

BetaPosterior Bounded(const BetaPosterior& posterior) {
  return {.alpha = std::clamp(posterior.alpha, kMinShape, kMaxShape),
          .beta = std::clamp(posterior.beta, kMinShape, kMaxShape)};
}

BetaPosterior Mirrored(const BetaPosterior& posterior) {
  return {.alpha = posterior.beta, .beta = posterior.alpha};
}

double LogGamma(double x) {
  double product = 1;
  double shifted = x;
  while (shifted < kStirlingFrom) {
    product *= shifted;
    ++shifted;
  }
  return StirlingLeading(shifted) + StirlingSeries(shifted) - math::Log(product);
}

double LogitMode(const BetaPosterior& posterior) {
  const BetaPosterior p = Bounded(posterior);
  return math::Log(p.alpha) - math::Log(p.beta);
}

double LogitLogPeak(const BetaPosterior& posterior) {
  const BetaPosterior p = Bounded(posterior);
  const double n = p.alpha + p.beta;
  return 0.5 * math::Log(p.alpha / n * p.beta) - kHalfLog2Pi + StirlingError(n) -
         StirlingError(p.alpha) - StirlingError(p.beta);
}

double LogitLogShape(const BetaPosterior& posterior, double offset) {
  BetaPosterior p = Bounded(posterior);
  if (p.alpha > p.beta) {
    p = Mirrored(p);
    offset = -offset;
  }
  const double n = p.alpha + p.beta;
  const double mean = p.alpha / n;  // at most ½
  // Computes the result relative to the mode, since the terms of α ln x + β ln(1 − x) would cancel.
  constexpr double kMaxExponent = 700;
  const double log_ratio =
      offset < kMaxExponent ? math::Log1p(mean * math::Expm1(offset)) : offset + math::Log(mean);
  return std::min(0.0, p.alpha * offset - n * log_ratio);
}

double BetaDistribution(const BetaPosterior& posterior, double x) {
  assert(x >= 0 && x <= 1);
  if (x <= 0) return 0;
  if (x >= 1) return 1;
  const double logit = math::Log(x) - math::Log1p(-x);
  return DistributionAt(Bounded(posterior), logit - LogitMode(posterior));
}

double BetaQuantile(const BetaPosterior& posterior, double p) {
  assert(p >= 0 && p <= 1);
  if (p <= 0) return 0;
  if (p >= 1) return 1;
  const BetaPosterior bounded = Bounded(posterior);
  const double offset =
      p <= 0.5 ? OffsetOfLowerTail(bounded, p) : -OffsetOfLowerTail(Mirrored(bounded), 1 - p);
  return FromLogit(LogitMode(bounded) + offset).x;
}

CredibleInterval CentralInterval(const BetaPosterior& posterior, double mass) {
  return {.low = BetaQuantile(posterior, (1 - mass) / 2),
          .high = BetaQuantile(posterior, (1 + mass) / 2)};
}

}  // namespace sweepstake::decision
