// The Beta distribution of an arm's reward: density, distribution function and quantiles, the same
// bits on every platform (portable_math.h).
//
// Pure functions, thread-safe. Both parameters may be anything that is finite and above 0; outside
// of [kSmallestShape, kLargestShape] they are taken as the nearer bound. Errors are those measured
// against 50 digits over that range (tests/server/decision/beta_distribution_test.cc).
#pragma once

#include "server/decision/types.h"

namespace sweepstake::decision {

inline constexpr double kSmallestShape = 1e-6;
inline constexpr double kLargestShape = 1e15;

// With the parameters within these bounds.
BetaPosterior Bounded(const BetaPosterior& posterior);
// Of 1 − the reward.
BetaPosterior Mirrored(const BetaPosterior& posterior);

// ln Γ(x). Error: 2e-14 absolute or 1e-15 relative, whichever is larger. REQUIRES: 1e-6 <= x <=
// 4e15. Cost: some 40 ns.
double LogGamma(double x);

// The density on the scale of logits, x^α (1 − x)^β / B(α, β), at logit = ln(x / (1 − x)), is
// exp(log_peak + LogShape(posterior, logit − mode)): its only peak is at the mode, where x is the
// mean.
double LogitMode(const BetaPosterior& posterior);
double LogitLogPeak(const BetaPosterior& posterior);
// <= 0, concave, 0 at offset 0. Error: 1e-13 relative, and some 1e-16 × √(α + β) absolute.
double LogitLogShape(const BetaPosterior& posterior, double offset);

// ln of the density of the reward at x. REQUIRES: 0 < x < 1. Error: 1e-12, and some 1e-16 ×
// √(α + β) where that is more.
double BetaLogDensity(const BetaPosterior& posterior, double x);

// P(reward <= x), the regularised incomplete beta function. Error: 1e-10, and up to 1e-9 towards α
// + β = 2e15; of results below 1e-3 where x is below the mean, so much of the result. Cost: 0.2–5
// µs. REQUIRES: 0 <= x <= 1.
double BetaDistribution(const BetaPosterior& posterior, double x);

// The reward which the arm's stays below with probability p: 0 where it is too small for a double.
// Error: that of BetaDistribution. Cost: some ten of it. REQUIRES: 0 <= p <= 1.
double BetaQuantile(const BetaPosterior& posterior, double p);

struct CredibleInterval {
  double low = 0;
  double high = 1;
};

// The central interval which the reward is in with this probability, e.g. 0.95: as much is below as
// above. REQUIRES: 0 <= mass <= 1.
CredibleInterval CentralInterval(const BetaPosterior& posterior, double mass);

}  // namespace sweepstake::decision
