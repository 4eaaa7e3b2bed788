// The Beta distribution of an arm's reward: density, distribution function and quantiles, with the
// same bits on every platform (portable_math.h).
//
// Pure functions, thread-safe. A parameter of a distribution outside of [kMinShape, kMaxShape] is
// treated as the nearer bound. The errors were measured against 50 digits over that range
// (tests/engine_client/math/beta_distribution_test.cc).
#pragma once

namespace sweepstake::decision {

// A Beta distribution of an arm's reward. Both parameters are finite and above 0.
struct BetaPosterior {
  double alpha = 1;
  double beta = 1;

  double mean() const { return alpha / (alpha + beta); }
  double evidence() const { return alpha + beta; }  // n in the paper, including the prior
  friend bool operator==(const BetaPosterior&, const BetaPosterior&) = default;
};

inline constexpr double kMinShape = 1e-6;
inline constexpr double kMaxShape = 1e15;

// Returns the posterior with both parameters clamped to these bounds.
BetaPosterior Bounded(const BetaPosterior& posterior);
// Returns the distribution of 1 − the reward.
BetaPosterior Mirrored(const BetaPosterior& posterior);

// Returns ln Γ(x). Error: 2e-14 absolute or 1e-15 relative, whichever is larger. REQUIRES: 1e-6 <=
// x <= 4e15.
double LogGamma(double x);

// The density of the reward's logit, ln(x / (1 − x)), is x^α (1 − x)^β / B(α, β). It has one peak,
// at LogitMode, where x is the mean. The logarithm of the density is LogitLogPeak +
// LogitLogShape(posterior, logit − LogitMode).
double LogitMode(const BetaPosterior& posterior);
double LogitLogPeak(const BetaPosterior& posterior);
// Returns ln(density at LogitMode + offset) − LogitLogPeak. It is <= 0, concave in `offset`, and 0
// at offset 0. Error: 1e-13 relative, and some 1e-16 × √(α + β) absolute.
double LogitLogShape(const BetaPosterior& posterior, double offset);

// Returns P(reward <= x), the regularised incomplete beta function. Error: 1e-10, up to 1e-9
// towards α + β = 2e15; for results below 1e-3 with x below the mean the error is relative.
// REQUIRES: 0 <= x <= 1.
double BetaDistribution(const BetaPosterior& posterior, double x);

// Returns the x with P(reward <= x) = p, or 0 if x is too small for a double. Error: as for
// BetaDistribution. Cost: some ten calls of BetaDistribution. REQUIRES: 0 <= p <= 1.
double BetaQuantile(const BetaPosterior& posterior, double p);

struct CredibleInterval {
  double low = 0;
  double high = 1;
};

// Returns the central interval that contains the reward with this probability, e.g. 0.95. The tails
// below and above it are equal. REQUIRES: 0 <= mass <= 1.
CredibleInterval CentralInterval(const BetaPosterior& posterior, double mass);

}  // namespace sweepstake::decision
