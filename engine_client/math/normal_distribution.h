// The standard normal distribution, with the same bits on every platform (portable_math.h).
//
// Pure functions, thread-safe. NaN gives NaN.
#pragma once

namespace sweepstake::decision {

// Returns φ(z).
double NormalDensity(double z);

// Returns Φ(z), within 1e-13 of the true value, relatively so in the lower tail; 0 below −38.
double NormalCdf(double z);

// Returns E[max(x, 0)] of a normal x with this mean and standard deviation: the expected gain of
// "expected improvement" (J. Mockus, 1978). >= 0. REQUIRES: deviation >= 0.
double ExpectedGain(double mean, double deviation);

}  // namespace sweepstake::decision
