// The Beta distribution of an arm's reward: density, distribution function and quantiles, with the
// same bits on every platform (portable_math.h).
//
// Pure functions, thread-safe. A parameter outside of [kMinShape, kMaxShape] counts as the nearer
// bound. The errors were measured against 50 digits over that range
// (tests/engine_client/math/beta_distribution_test.cc).
#pragma once

namespace sweepstake::decision {

// A Beta distribution of an arm's reward. Both parameters are finite and above 0.
struct BetaPosterior {
  double alpha = 1;
  double beta = 1;

  double mean() const { return alpha / (alpha + beta); }
  double evidence() const { return alpha + beta; }  // the paper's n, prior included
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

// The density on the scale of logits, x^α (1 − x)^β / B(α, β), at logit = ln(x / (1 − x)), is
// exp(log_peak + LogShape(posterior, logit − mode)): its only peak is at the mode, where x is the
// mean.
double LogitMode(const BetaPosterior& posterior);
double LogitLogPeak(const BetaPosterior& posterior);
// <= 0, concave, 0 at offset 0. Error: 1e-13 relative, and some 1e-16 × √(α + β) absolute.
double LogitLogShape(const BetaPosterior& posterior, double offset);

// Returns P(reward <= x), the regularised incomplete beta function. Error: 1e-10, up to 1e-9
// towards α + β = 2e15; for results below 1e-3 with x below the mean the error is relative.
// REQUIRES: 0 <= x <= 1.
double BetaDistribution(const BetaPosterior& posterior, double x);

// Returns the reward below which the arm is with probability p; 0 if it is too small for a double.
// Error: that of BetaDistribution. Cost: some ten calls of it. REQUIRES: 0 <= p <= 1.
double BetaQuantile(const BetaPosterior& posterior, double p);

struct CredibleInterval {
  double low = 0;
  double high = 1;
};

// Returns the central interval that contains the reward with this probability, e.g. 0.95. The tails
// below and above it are equal. REQUIRES: 0 <= mass <= 1.
CredibleInterval CentralInterval(const BetaPosterior& posterior, double mass);

}  // namespace sweepstake::decision
