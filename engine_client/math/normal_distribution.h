// The standard normal distribution, with the same bits on every platform (portable_math.h).
//
// Pure functions, thread-safe. NaN gives NaN.
#pragma once

namespace sweepstake::decision {

// Returns φ(z).
double NormalDensity(double z);

// Returns Φ(z). The absolute error is below 1e-13, and in the lower tail the relative error is
// below 1e-13 too. Returns 0 for z below −38.
double NormalCdf(double z);

// Returns E[max(x, 0)] for a normal x with this mean and standard deviation: the expected gain of
// "expected improvement" (J. Mockus, 1978). The result is >= 0. REQUIRES: deviation >= 0.
double ExpectedGain(double mean, double deviation);

}  // namespace sweepstake::decision
